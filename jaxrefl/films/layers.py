r"""Fields in a stack of layers: Abeles' characteristic matrices, in which no exponential grows.

Everything is relative to the medium of incidence: N = (n + i k) / n_outside, c = cos theta, and in every medium
q = N cos theta_j = sqrt(N^2 - sin^2 theta), Im q >= 0, with the admittance y_s = q, y_p = q / N^2. The tangential
fields (a, b), which for s are E and H and for p H and E, go from the lower to the upper face of a layer as

    a' = C a - i S w b,    b' = C b - i S (q^2 / w) a,    C = cos(q x), S = sin(q x) / q,    w = 1 (s) or N^2 (p)

with x = 2 pi n_outside d / lambda. C and S are entire functions of q^2: nothing happens in a layer at its critical
angle, and no branch of its root is chosen. Where |q x| is small they are power series in q^2 x^2; elsewhere both are
divided by exp(-i q x), which leaves, with E = exp(2 i q x), |E| <= 1,

    C = (1 + E) / 2,    S = i (1 - E) / (2 q)

and hands the decaying exp(i q x) to the transmitted field. A deep absorbing layer is thus exactly its bulk. At the top
a wave that comes from a medium of admittance y is reflected with r = (y a - b) / (y a + b), and 1 - |r|^2 =
4 Re(y a b*) / |y a + b|^2. The signs are those of `jaxrefl.fresnel`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import jax.numpy as jnp
from jax import Array, lax

from ..fresnel.exact import _q_squared, _root, _smaller_first
from ..safe import safe_divide

_NEAR, _TERMS = 1 / 16, 7  # power series for |q^2 x^2| < 1/16: the term that follows the last is (1/16)^7 / 14!


class Fields(NamedTuple):
    """Tangential fields (a, b), and the part of the field a that reaches the bottom; the first axis is (s, p)."""

    a: Array
    b: Array
    through: Array


class Medium(NamedTuple):
    """Half-space, or thick layer: q = N cos theta, and the admittances (s, p)."""

    q: Array
    y: Array


class Response(NamedTuple):
    """What a stack does to a wave: amplitudes of the field a, and fractions of the power; the first axis is (s, p)."""

    r: Array
    t: Array
    reflected: Array
    kept: Array
    """1 - reflected, accurate where it is small."""
    transmitted: Array


def to_complex(re: Array, im: Array) -> Array:
    """Complex number of two parts that broadcast."""
    return lax.complex(*jnp.broadcast_arrays(re, im))


def square(z: Array) -> Array:
    """|z|^2, with a derivative at 0."""
    return z.real * z.real + z.imag * z.imag


def inverse(z: Array) -> Array:
    """1 / z, 0 where it would leave the dtype. A division of complex numbers has ten times as much to compile."""
    size = lax.stop_gradient(jnp.abs(z.real) + jnp.abs(z.imag))
    zero = size < jnp.sqrt(jnp.finfo(size.dtype).tiny)
    scale = 1 / jnp.where(zero, 1.0, size)
    z = jnp.where(zero, 1.0, z * scale)
    return jnp.where(zero, 0.0, z.conj() * (scale / square(z)))


def _squares(c: Array, eta: Array, kappa: Array) -> tuple[Array, tuple[Array, Array]]:
    """N^2, and the two parts of q^2 = N^2 - sin^2 theta."""
    n2_im = 2 * eta * kappa
    return to_complex(eta * eta - kappa * kappa, n2_im), (_q_squared(c, eta) - kappa * kappa, n2_im)


def medium(c: Array, eta: Array, kappa: Array) -> Medium:
    """Half-space, or thick layer, of relative index eta + i kappa; c of the shape of the result."""
    n2, (re, im) = _squares(c, eta, kappa)
    critical = jnp.abs(re) + im < jnp.sqrt(jnp.finfo(c.dtype).tiny)  # where the slope of the root would leave the dtype
    q = to_complex(*_root(*(jnp.where(critical, lax.stop_gradient(part), part) for part in (re, im))))
    q = jnp.broadcast_to(q, c.shape)
    return Medium(q, jnp.stack([q, q * inverse(n2)]))


def _matrix(q2_re: Array, q2_im: Array, x: Array) -> tuple[Array, Array, Array]:
    """C, S and the exponential that was divided out of them."""
    q2_re, q2_im, x = jnp.broadcast_arrays(q2_re, q2_im, x)
    small = (jnp.abs(q2_re) + jnp.abs(q2_im)) * x * x < _NEAR
    near, far = jnp.where(small, x, 0.0), jnp.where(small, 0.0, x)
    z = lax.complex(jnp.where(small, q2_re, 0.0), jnp.where(small, q2_im, 0.0)) * near * near
    c, s = jnp.zeros_like(z), jnp.zeros_like(z)
    for i in reversed(range(_TERMS)):
        c, s = c * z + (-1.0) ** i / math.factorial(2 * i), s * z + (-1.0) ** i / math.factorial(2 * i + 1)
    a, b = _root(jnp.where(small, 1.0, q2_re), jnp.where(small, 0.0, q2_im))
    decay = jnp.exp(-far * b)
    once = lax.complex(decay * jnp.cos(far * a), decay * jnp.sin(far * a))
    c = jnp.where(small, c, 0.5 * (1 + once * once))
    s = jnp.where(small, near * s, 0.5j * (1 - once * once) * inverse(lax.complex(a, b)))
    return c, s, once


# functions of the module, not closures: so that `scan` compiles each once, also where nothing is under `jit`
def _layer_kept(state: tuple[Array, Fields], given: tuple[Array, Array, Array]) -> tuple[Any, Fields]:
    """Fields at the upper face of a layer, scaled to order 1, from those at the lower; and with what it alone divides.

    The scale drops out of every ratio that is used.
    """
    (c, below), (eta, kappa, x) = state, given
    n2, (q2_re, q2_im) = _squares(c, eta, kappa)
    n2, q2 = jnp.broadcast_to(n2, c.shape), to_complex(q2_re, q2_im)
    cosine, sine, once = _matrix(q2_re, q2_im, x)
    down, up = (
        -1j * sine * jnp.stack([jnp.ones_like(n2), n2]),
        -1j * sine * q2 * jnp.stack([jnp.ones_like(n2), inverse(n2)]),
    )
    a, b = cosine * below.a + down * below.b, cosine * below.b + up * below.a
    size = lax.stop_gradient(jnp.sqrt(square(a) + square(b)))
    scale = safe_divide(1.0, size, fill=1.0)
    own = Fields(a * scale, b * scale, once * scale)
    return (c, own._replace(through=own.through * below.through)), own


def _layer(state: tuple[Array, Fields], given: tuple[Array, Array, Array]) -> tuple[Any, None]:
    return _layer_kept(state, given)[0], None


def _leaving(below: Medium) -> Fields:
    one = jnp.ones_like(below.y)
    return Fields(one, below.y, one)


def fields(c: Array, layers: tuple[Array, Array, Array], below: Medium) -> Fields:
    """Fields at the top of the layers, for the wave that leaves below with a = 1.

    Args:
        c: cosine of the angle of incidence, of the shape of the result.
        layers: eta, kappa and x, the first axis that of the layers, from the top down.
        below: half-space behind them.
    """
    start = _leaving(below)
    if layers[0].shape[0] == 0:  # nothing to compile
        return start
    (_, top), _ = lax.scan(_layer, (c, start), layers, reverse=True)
    return top


def fields_everywhere(c: Array, layers: tuple[Array, Array, Array], below: Medium) -> tuple[Fields, Fields]:
    """The same, and the fields at the top of every layer, their ``through`` being that of this layer alone."""
    (_, top), tops = lax.scan(_layer_kept, (c, _leaving(below)), layers, reverse=True)
    return top, tops


def respond(above: Medium, top: Fields, below: Medium) -> Response:
    """Reflection and transmission of a wave that comes from above.

    Where y and b are both 0 (grazing incidence on the index of outside) the wave goes on as if nothing were there.
    """
    y = above.y
    total = y * top.a + top.b
    over = inverse(total)
    nothing = over == 0
    r, t = (y * top.a - top.b) * over, jnp.where(nothing, 1.0, 2 * y * over * top.through)
    kept = 4 * ((y * top.a * over) * (top.b * over).conj()).real  # 1 - |r|^2, without the difference
    incident = y.real + y.imag * safe_divide(y.imag, y.real)  # |y|^2 / Re y; in all that are used |Im y| <= Re y
    transmitted = 4 * ((incident * over) * (below.y.real * over).conj()).real * square(top.through)
    kept, transmitted = jnp.where(nothing, 1.0, kept), jnp.where(nothing, 1.0, transmitted)
    return Response(r, t, _smaller_first(square(r), kept), kept, transmitted)
