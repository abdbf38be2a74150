"""Recursive ray tracer in plain NumPy: the second implementation, written from the source documents alone.

It shares no code with jaxrefl: scenes are read by the names of their classes and attributes. One ray at a time and
slow; pictures of a few hundred pixels are what it is for. Where the documents leave a choice, it is made here:

- A surface acts on both of its sides; the inside of a plane is the side away from its normal.
- Every shadow ray is stopped by whatever it meets before the light, glass too.
- The extinction of a reflected ray (sigma_rg) is added to that of the medium in which the ray runs.
- Radiance is basic, L / n^2. The camera stands outside, n = 1; a ray that leaves an object is outside again.
- 0^0 = 1: a lobe with exponent 0 is constant.
- Of the bases of a composed surface, only `Phong` is known.
"""

from types import SimpleNamespace

import numpy as np

# fields by class: "*" after a name marks a colour (C,), ">" a vector, "!" a switch
FIELDS = {
    "Sphere": "center> radius",
    "Plane": "point_on> normal>",
    "Phong": "k_d* k_s* shininess k_a* emission* highlight!",
    "Blend": "base reflectivity*",
    "Whitted": "base k_rg* k_tg* eta sigma_rg* sigma_tg*",
    "D3D9": "base metallic* r0 m p specular* metallic_norm sun_fresnel!",
    "Dielectric": "eta sigma*",
    "Conductor": "eta* k*",
    "Coat": "base eta",
    "Checker": "even* odd* squares_u squares_v",
    "ImageTexture": "pixels* scale_u scale_v",
    "Ambient": "intensity*",
    "Directional": "direction> diffuse* specular* ambient* shadows!",
    "PointLight": "position> diffuse* specular* ambient* constant linear quadratic shadows!",
    "Spot": "position> direction> exponent cutoff diffuse* specular* ambient* constant linear quadratic shadows!",
    "Sky": "zenith* horizon* nadir*",
    "Pinhole": "position> target> up> field_of_view",
    "Orthographic": "position> target> up> height",
}


# ---------------------------------------------------------------- reading the scene


def fields_of(model):
    """Name, mark and value of each field."""
    for word in FIELDS[type(model).__name__].split():
        name = word.rstrip("*>!")
        yield name, word[len(name) :], getattr(model, name)


def is_model(value):
    return type(value).__name__ in FIELDS


def leaves(model):
    """Mark and value of each number in a model and in the models in its fields; switches and None left out."""
    for _, mark, value in fields_of(model):
        if is_model(value):
            yield from leaves(value)
        elif value is not None and mark != "!":
            yield mark, array_of(value, mark)


def array_of(value, mark):
    """Array of a field; of a vector, however it was given, (3,) or (n, 3)."""
    if mark == ">" and hasattr(value, "x"):
        return np.stack(np.broadcast_arrays(*(np.asarray(c, float) for c in (value.x, value.y, value.z))), axis=-1)
    return np.asarray(value, float)


def count(model):
    """Number n of primitives of an object, from the axis before that of a colour or vector; pictures have none."""
    return max([1, *(len(a) for mark, a in leaves(model) if a.ndim == 1 + bool(mark))])


def channels(model):
    """Largest number of channels of its colours."""
    return max([1, *(a.shape[-1] for mark, a in leaves(model) if mark == "*" and a.ndim)])


def unpack(model, i=0):
    """Primitive i of a model: numbers are floats, vectors (3,), colours (C,) or (1,)."""
    kind = type(model).__name__
    out = SimpleNamespace(kind=kind)
    for name, mark, value in fields_of(model):
        if is_model(value):
            value = unpack(value, i)
        elif value is not None and mark != "!":
            value = array_of(value, mark)
            if value.ndim == 1 + bool(mark):
                value = value[i if len(value) > 1 else 0]
            value = np.atleast_1d(value) if mark else float(value)
        setattr(out, name, value)
    return out


# ---------------------------------------------------------------- vectors, Fresnel, textures


def unit(v):
    return v / np.sqrt(v @ v)


def mirrored(d, n):
    """Direction d, travelling, after a mirror with normal n."""
    return d - 2 * (d @ n) * n


def refracted(d, n, eta):
    """Snell's law for d travelling against n into eta = n_t / n_i; None is total reflection."""
    along = d - (d @ n) * n  # length sin(theta_i)
    sin_t = along / eta
    rest = 1 - sin_t @ sin_t
    return None if rest < 0 else sin_t - np.sqrt(rest) * n


def fresnel_dielectric(mu, eta):
    """Unpolarised reflectance of n_t / n_i = eta at cos(theta_i) = mu."""
    sin2_t = (1 - mu * mu) / (eta * eta)
    if sin2_t > 1:
        return 1.0
    mu_t = np.sqrt(1 - sin2_t)
    r_s, r_p = (mu - eta * mu_t) / (mu + eta * mu_t), (eta * mu - mu_t) / (eta * mu + mu_t)
    return (r_s * r_s + r_p * r_p) / 2


def fresnel_conductor(mu, eta, k):
    """Unpolarised reflectance of eta + i k, per channel; moduli of the complex amplitudes (S36)."""
    index = eta + 1j * k
    mu_t = np.sqrt(1 - (1 - mu * mu) / index**2)  # Re(index * mu_t) > 0 on the principal branch
    r_s, r_p = (mu - index * mu_t) / (mu + index * mu_t), (index * mu - mu_t) / (index * mu + mu_t)
    return (abs(r_s) ** 2 + abs(r_p) ** 2) / 2


def fresnel_d3d9(surface, mu):
    """D3D9 (3)."""
    return surface.r0 + surface.m * max(0.0, 1 - mu) ** surface.p


def at(value, uv):
    """Value of a parameter at (u, v), a texture or not."""
    kind = getattr(value, "kind", None)
    if kind == "Checker":
        squares = np.floor(uv[0] * value.squares_u) + np.floor(uv[1] * value.squares_v)
        return value.even if squares % 2 == 0 else value.odd
    if kind == "ImageTexture":
        rows, columns = value.pixels.shape[:2]
        x, y = uv[0] * value.scale_u * columns - 0.5, uv[1] * value.scale_v * rows - 0.5
        c, r = int(np.floor(x)), int(np.floor(y))
        return sum(
            (1 - abs(x - cc)) * (1 - abs(y - rr)) * value.pixels[rr % rows, cc % columns]
            for rr in (r, r + 1)
            for cc in (c, c + 1)
        )
    return value


def number(value, uv):
    """Scalar parameter at (u, v): the first channel of a texture."""
    return float(np.ravel(at(value, uv))[0])


# ---------------------------------------------------------------- where a ray hits


def distance_to(shape, o, d, size):
    """Nearest distance above 1e-9 of the size of the numbers that made o: "t < EPSILON implies the ray is on it"."""
    if shape.kind == "Plane":
        n, away = unit(shape.normal), shape.point_on - o
        size, slope = size + np.abs(shape.point_on).max(), d @ n
        roots = [(away @ n) / slope] if slope else []
    else:
        away = shape.center - o
        size, middle = size + np.abs(shape.center).max() + shape.radius, away @ d
        foot = away - middle * d  # centre to line
        left = shape.radius**2 - foot @ foot
        roots = [middle - np.sqrt(left), middle + np.sqrt(left)] if left >= 0 else []
    return next((t for t in roots if t > 1e-9 * size), np.inf)


def outside_normal_and_uv(shape, p):
    if shape.kind == "Plane":
        n = unit(shape.normal)
        axis = np.array([0.0, 1.0, 0.0] if abs(n[0]) > 0.95 else [1.0, 0.0, 0.0])
        tangent = unit(axis - (axis @ n) * n)
        return n, ((p - shape.point_on) @ tangent, (p - shape.point_on) @ np.cross(n, tangent))
    n = unit(p - shape.center)
    return n, (np.arctan2(n[1], n[0]) / (2 * np.pi) % 1, np.arctan2(np.hypot(n[0], n[1]), n[2]) / np.pi)


class Tracer:
    """One scene; `color` is the recursion."""

    def __init__(self, scene, n_bounces):
        items = [scene.objects[name] for name in sorted(scene.objects)]
        sizes = [max(count(item.shape), count(item.surface)) for item in items]
        self.shapes = [unpack(item.shape, i) for item, n in zip(items, sizes, strict=True) for i in range(n)]
        self.surfaces = [unpack(item.surface, i) for item, n in zip(items, sizes, strict=True) for i in range(n)]
        lights = [unpack(light) for light in scene.lights.values()]
        self.lights = [light for light in lights if light.kind != "Ambient"]
        self.ambient = sum((light.intensity for light in lights if light.kind == "Ambient"), np.zeros(1))
        plain = not is_model(scene.background)
        self.sky = np.atleast_1d(np.asarray(scene.background, float)) if plain else unpack(scene.background)
        self.n_bounces = n_bounces
        models = [*(item.surface for item in items), *scene.lights.values(), *([] if plain else [scene.background])]
        self.channels = max([len(self.sky) if plain else 1, *map(channels, models)])

    def background(self, d):
        if not isinstance(self.sky, SimpleNamespace):
            return self.sky
        end = self.sky.zenith if d[2] > 0 else self.sky.nadir
        return self.sky.horizon + abs(d[2]) * (end - self.sky.horizon)

    def nearest(self, o, d, size):
        distances = [distance_to(shape, o, d, size) for shape in self.shapes]
        i = int(np.argmin(distances)) if distances else 0  # the first of equal ones
        return (i, distances[i]) if distances and distances[i] < np.inf else (None, np.inf)

    def light_at(self, light, p, size):
        """Direction to a light, what falls off on the way (f_att S_j), and whether it is seen."""
        if light.kind == "Directional":
            wi, distance, factor = -unit(light.direction), np.inf, 1.0
        else:
            distance = np.sqrt((light.position - p) @ (light.position - p))
            wi = (light.position - p) / distance
            fall = light.constant + light.linear * distance + light.quadratic * distance**2
            factor = 1 / fall if fall > 0 else 0.0
        if light.kind == "Spot":
            cos_angle = -unit(light.direction) @ wi  # S25
            factor *= max(0.0, cos_angle) ** light.exponent if cos_angle >= np.cos(light.cutoff) else 0.0
        blocked = light.shadows and self.nearest(p, wi, size)[1] < distance
        return wi, factor, 0.0 if blocked else 1.0

    def local(self, base, p, size, n, wo, uv, dim=lambda cos_theta: 1.0):
        """JHU's equation; ``dim`` multiplies the diffuse light that comes from an angle."""
        total = at(base.emission, uv) + self.ambient * at(base.k_a, uv)
        for light in self.lights:
            wi, factor, seen = self.light_at(light, p, size)
            cos_theta, one = n @ wi, light.ambient * at(base.k_a, uv)
            if cos_theta > 0:
                if base.highlight == "mirror":
                    lobe = max(0.0, (2 * cos_theta * n - wi) @ wo)
                else:
                    lobe = max(0.0, unit(wi + wo) @ n)
                one = one + seen * light.diffuse * at(base.k_d, uv) * cos_theta * dim(cos_theta)
                one = one + seen * light.specular * at(base.k_s, uv) * lobe**base.shininess
            total = total + factor * one
        return total

    def color(self, o, d, size=0.0, depth=0, index=1.0, medium=0.0, extra=0.0):
        """Basic radiance along a ray in a medium of a refractive index; extinction ``medium`` and ``extra``."""
        sigma = np.atleast_1d(medium + extra)
        i, t = self.nearest(o, d, size)
        if i is None:
            return np.where(sigma > 0, 0.0, self.background(d) / index**2)
        s, p, wo = self.surfaces[i], o + t * d, -d
        n, uv = outside_normal_and_uv(self.shapes[i], p)
        entering = d @ n < 0
        n = n if entering else -n
        mu, size = min(1.0, wo @ n), t + np.abs(o).max()
        hit = p, size, n, wo, uv

        shown, reflected, transmitted, inside, extra, bent = 0.0, 0.0, None, 0.0, 0.0, None
        if s.kind == "Phong":
            shown = self.local(s, *hit)
        elif s.kind == "Blend":  # PERRIN (1)
            reflected = at(s.reflectivity, uv)
            shown = (1 - reflected) * self.local(s.base, *hit)
        elif s.kind == "Whitted":
            shown = self.local(s.base, *hit)
            reflected = 0.0 if s.k_rg is None else at(s.k_rg, uv)
            transmitted = None if s.k_tg is None else at(s.k_tg, uv)
            inside = 0.0 if s.sigma_tg is None else at(s.sigma_tg, uv)
            extra = 0.0 if s.sigma_rg is None else at(s.sigma_rg, uv)
        elif s.kind == "D3D9":  # (5), (6), (8)
            metallic, r = at(s.metallic, uv), fresnel_d3d9(s, mu)
            reflected = metallic * (1 - r) + at(s.specular, uv) * r
            largest = metallic.max() if s.metallic_norm is None else s.metallic_norm
            dim = (lambda cos_theta: 1 - fresnel_d3d9(s, cos_theta)) if s.sun_fresnel else (lambda cos_theta: 1.0)
            shown = (1 - largest) * self.local(s.base, *hit, dim)
        elif s.kind == "Dielectric":
            reflected = fresnel_dielectric(mu, s.eta if entering else 1 / s.eta)
            transmitted, inside = 1 - reflected, 0.0 if s.sigma is None else s.sigma
        elif s.kind == "Conductor":
            reflected = fresnel_conductor(mu, s.eta, s.k)
        elif s.kind == "Coat":
            reflected = fresnel_dielectric(mu, s.eta)
            shown = (1 - reflected) * self.local(s.base, *hit)

        total = shown / index**2
        if transmitted is not None:
            eta = number(s.eta, uv)
            bent = refracted(d, n, eta if entering else 1 / eta)
            if bent is None:
                reflected, transmitted = reflected + transmitted, None
        if depth < self.n_bounces and np.any(reflected):
            total = total + reflected * self.color(p, mirrored(d, n), size, depth + 1, index, medium, extra)
        if depth < self.n_bounces and bent is not None and np.any(transmitted):
            into = (eta, inside) if entering else (1.0, 0.0)
            total = total + transmitted * self.color(p, bent, size, depth + 1, *into)
        return np.exp(-sigma * t) * total


# ---------------------------------------------------------------- the picture


def camera_ray(camera, x, y):
    forward = unit(camera.target - camera.position)
    right = unit(np.cross(forward, camera.up))
    up = np.cross(right, forward)
    if camera.kind == "Orthographic":
        return camera.position + camera.height / 2 * (x * right + y * up), forward
    scale = np.tan(camera.field_of_view / 2)
    return camera.position, unit(forward + scale * (x * right + y * up))


def reference(scene, camera, width, height, n_bounces):
    """Radiance (H, W, C) through the centres of the pixels."""
    tracer, camera = Tracer(scene, n_bounces), unpack(camera)
    picture = np.empty((height, width, tracer.channels))
    for r, c in np.ndindex(height, width):
        x, y = (2 * (c + 0.5) / width - 1) * width / height, 1 - 2 * (r + 0.5) / height
        picture[r, c] = tracer.color(*camera_ray(camera, x, y))
    return picture
