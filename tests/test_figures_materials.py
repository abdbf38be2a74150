"""The claims of the captions about dispersion and Drude-Lorentz fits."""

import numpy as np
import pytest
from figure_claims import says

pytestmark = pytest.mark.usefixtures("quick_compilation")


def test_dispersion(figure):
    data, caption = figure("dispersion")
    of = {name: i for i, name in enumerate(data["names"])}
    bk7, sf11, diamond = (of[name] for name in ("N-BK7", "SF11", "diamond"))
    says(caption, f"{data['n_d'][bk7]:.5f} and V_d = {data['abbe'][bk7]:.2f}")
    says(caption, f"SF11 {data['n_d'][sf11]:.5f} and {data['abbe'][sf11]:.2f}")
    says(caption, f"{data['n_d'][diamond]:.5f}", f"{data['abbe'][diamond]:.2f}")
    says(caption, f"{data['excess_F'][sf11]:.3f} in SF11", f"{data['excess_F'][bk7]:.3f} in N-BK7")
    assert data["n_d"].argmax() == diamond
    assert (data["group"] > data["n"]).all()
    # the slope of the group index, against differences of n
    nm, n = data["wavelength_nm"], data["n"]
    numeric = n - nm * np.gradient(n, nm, axis=1)
    np.testing.assert_allclose(data["group"][:, 1:-1], numeric[:, 1:-1], atol=1e-4)


def test_drude_lorentz(figure):
    data, caption = figure("drude_lorentz")
    of = {name: i for i, name in enumerate(data["metals"])}
    worst = data["max"][:, 2]
    assert data["converged"].all()
    says(caption, f"{worst[of['Cr']]:.2f} for chromium", f"{worst[of['Au']]:.2f} for gold and copper")
    says(caption, f"{worst[of['Cu']]:.2f} for gold and copper", f"by {worst[of['Ag']]:.2f} at")
    silver = data["wavelength_nm"][of["Ag"]]
    says(caption, f"{silver[np.abs(data['r_error'][of['Ag']]).argmax()]:.1f} nm")
    says(caption, f"{data['wavelength_nm'].min():.0f} to {data['wavelength_nm'].max():.0f} nm")
    np.testing.assert_allclose(np.abs(data["r_error"]).max(axis=1), worst, rtol=1e-9)
    infrared = data["wavelength_nm"] > 800
    for errors in (data["n_error"], data["k_error"]):
        far, near = (np.sqrt(np.mean(errors**2, axis=1, where=where)) for where in (infrared, ~infrared))
        assert (far > near).all()
    says(caption, "beyond 800 nm", f"R within {np.abs(data['r_error'])[infrared].max():.3f}")
    squares = data["n_error"] ** 2 + data["k_error"] ** 2
    total = (squares / (data["n"] ** 2 + data["k"] ** 2) + data["r_error"] ** 2).sum(axis=1)
    assert total[of["Ag"]] < 0.4445  # 0.7309 at the next of the minima
