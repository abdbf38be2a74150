"""Double precision for the session, one hypothesis profile, and a way back to JAX's float32 default."""

import functools
from collections.abc import Callable, Iterator

import hypothesis
import jax
import numpy as np
import pytest

from jaxrefl import gallery

with np.printoptions():  # importing it changes those of numpy, for whatever test comes next in the process
    import colour  # noqa: F401

jax.config.update("jax_enable_x64", True)
hypothesis.settings.register_profile("jaxrefl", deadline=None, derandomize=True, max_examples=60)
hypothesis.settings.load_profile("jaxrefl")


@pytest.fixture
def float32() -> Iterator[None]:
    """JAX as a user finds it: 64-bit types off while the test runs."""
    with jax.enable_x64(False):
        yield


@pytest.fixture(scope="module")
def quick_compilation() -> Iterator[None]:
    """XLA without most of its optimisations: half the time where compiling is all that takes time."""
    jax.config.update("jax_disable_most_optimizations", True)
    yield
    jax.config.update("jax_disable_most_optimizations", False)


@pytest.fixture(scope="module")
def figure() -> Callable[[str], tuple[dict[str, np.ndarray], str]]:
    """Computed data and caption of a figure, each computed once."""

    @functools.cache
    def get(name: str) -> tuple[dict[str, np.ndarray], str]:
        entry = gallery.load(name)
        return {key: np.asarray(value) for key, value in entry.compute().items()}, entry.caption

    return get
