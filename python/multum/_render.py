"""From scenes to pictures."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _multum
from ._arguments import count, image_size, name, number
from ._camera import Camera
from ._environment import Environment
from ._material import Layer, Material, TextureSlot
from ._scene import Scene
from .light import Light, to_parts


@dataclass(frozen=True)
class TextureUse:
    """How a view uses one picture; see :func:`right_size`."""

    image: int
    """Index into :attr:`Mesh.images`."""
    name: str
    size: tuple[int, int]
    """Width and height in texels."""
    reads: int
    """Reads of a pixel for a slot."""
    histogram: list[int]
    """Reads by level of detail: those that enlarge, then 0 to 1, 1 to 2, ..."""
    touched: float
    """Share of the texels under the footprint of any pixel, to a cell of 1/256 of a side."""
    recommended: tuple[int, int]
    """The smallest of the sizes W/2^k by H/2^k that keeps what 95 in 100 reads can show."""


def _slot(slot: TextureSlot) -> dict[str, Any]:
    if not isinstance(slot, TextureSlot):
        raise TypeError(f"materials: got {slot!r}, expected a TextureSlot")
    return vars(slot)


def _material(material: Material) -> dict[str, Any]:
    fields = {
        key: _slot(value) if key.endswith("_texture") and value is not None else value
        for key, value in vars(material).items()
    }
    for key in ("base_color", "emissive", "ambient", "specular", "mirror"):
        fields[key] = [float(x) for x in fields[key]]

    def layer(value: Layer) -> tuple[dict[str, Any], str, bool]:
        return _slot(value.texture), value.blend, bool(value.after_light)

    return {**fields, "layers": [layer(value) for value in material.layers]}


def _drawing(scene: Scene) -> _multum.Drawing:
    if not isinstance(scene, Scene):
        raise TypeError(f"scene: got {scene!r}, expected a Scene")
    mesh = scene.mesh
    parts = {
        **vars(mesh),
        "materials": [_material(material) for material in mesh.materials],
        "images": [
            (image.name, None if image.path is None else str(image.path), image.data, image.pixels)
            for image in mesh.images
        ],
    }
    return _multum.Drawing(parts)


def _camera(scene: Scene, camera: Camera | str, size: tuple[SupportsIndex, SupportsIndex]) -> _multum.Camera:
    if isinstance(camera, Camera):
        return camera._native
    return scene.camera(name("camera", camera), size)._native


def _background(background: ArrayLike | str | None) -> tuple[float, float, float, float]:
    if background is None:
        return 0.0, 0.0, 0.0, 0.0
    try:
        color = np.asarray(background, np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"background: got {background!r}, expected numbers") from None
    if color.ndim == 0:
        color = np.repeat(color, 3)
    if color.shape not in ((3,), (4,)):
        raise ValueError(f"background: got shape {color.shape}, expected one, 3 or 4 numbers")
    r, g, b, a = (float(x) for x in (*color, 1.0)[:4])
    return r, g, b, a


def _sampling(filter: str, max_anisotropy: float | None, lod_bias: float, threads: Any) -> _multum.Sampling:
    return _multum.Sampling(
        "auto" if name("filter", filter) == "file" else filter,
        np.inf if max_anisotropy is None else number("max_anisotropy", max_anisotropy),
        number("lod_bias", lod_bias),
        "major",
        None,
        0,
        count("threads", threads),
    )


def render(
    scene: Scene,
    camera: Camera | str = "auto",
    size: tuple[SupportsIndex, SupportsIndex] = (640, 480),
    filter: str = "auto",
    *,
    output: str = "srgb8",
    background: ArrayLike | str | None = None,
    lights: Iterable[Light] | None = None,
    environment: Environment | None = None,
    shadows: SupportsIndex | None = None,
    shadow_softness: float = 1.5,
    bump_curvature: bool = False,
    displacement_edge: float = 4.0,
    supersample: SupportsIndex = 1,
    max_anisotropy: float | None = 16,
    lod_bias: float = 0.0,
    debug: str | None = None,
    threads: SupportsIndex | None = None,
    progress: Callable[[float], object] | None = None,
) -> NDArray[Any]:
    """Draw a scene: every texture filtered over the piece of it that each pixel covers.

    Faces are lit by the Phong model; base colours, normal and bump maps, occlusion, emission, alpha (opaque,
    mask, blended in depth order whatever the order of faces), vertex colours, unlit and double-sided
    materials are as in glTF. Nothing of a texture that no pixel shows is decoded.

    Parameters
    ----------
    scene : Scene
    camera : Camera or str
        A camera, the name of one of the scene's, or ``"auto"``: the scene's first, else one that frames it in a
        picture of this size.
    size : (int, int)
        Width and height in pixels, 1 to 16384.
    filter : str
        How textures are sampled; names as in :meth:`Texture.sample`. ``"file"`` uses the filters that the
        file names for enlarging and reducing each texture, and ``"auto"`` where it names none.
    output : str
        ``"srgb8"``: uint8 codes with straight alpha, as image files hold and screens show them, light above 1
        cut off. ``"linear"``: float32 light with premultiplied alpha, as compositing needs it.
    background : 1, 3 or 4 numbers, or "environment", optional
        Linear colour, and straight alpha, behind everything; None for transparent; or the environment itself.
    lights : iterable of lights, optional
        Instead of the scene's.
    environment : Environment, optional
        Light from all sides: matt surfaces show its average, shining ones mirror it, each pixel the piece that its
        reflected rays meet. With it, and without lights, no lamp is added.
    shadows : int, optional
        Side in texels of the depth textures, one a light (six for lamps that shine to all sides); None for no
        shadows. Opaque faces and what the alpha of masked ones leaves cast them.
    shadow_softness : float
        Least width of a shadow's edge, in texels of the depth texture; it is never narrower than a pixel.
    bump_curvature : bool
        Whether bump maps count the terms with the curvature of the surface, d n_u and d n_v.
    displacement_edge : float
        Faces with displacement maps are cut until no edge is longer than so many pixels of the drawing.
    supersample : int
        Pixels of the drawing along each side of a pixel of the picture, 1 to 8: smooth edges of faces.
    max_anisotropy, lod_bias
        As in :meth:`Texture.sample`.
    debug : str, optional
        What the first texture of each material sees, instead of light: ``"uv"`` (u red, v green),
        ``"footprint"`` (ratio of axes, blue 1 to red 16), ``"lod"`` (blue 0 to red 6, white enlarged),
        ``"normals"`` or ``"checker"`` (32 by 32 fields in the unit square).
    threads : int, optional
        Threads to use; the result does not depend on it.
    progress : callable, optional
        Called now and then with the share that is done.

    Returns
    -------
    array, shape (H, W, 4)

    Raises
    ------
    ValueError, TypeError
        For arguments, meshes, materials or lights that are not as above.
    OSError
        When a texture cannot be read.

    Examples
    --------
    >>> import multum as mt
    >>> square = [[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]]
    >>> mesh = mt.Mesh.build(square, [[0, 3, 2], [0, 2, 1]], material=mt.Material(unlit=True))
    >>> mt.render(mt.Scene(mesh), mt.Camera((0, 0, 3)), (32, 24))[12, 16].tolist()
    [255, 255, 255, 255]
    """
    if name("output", output) not in ("srgb8", "linear"):
        raise ValueError(f"output: got {output!r}, expected 'srgb8' or 'linear'")
    if progress is not None and not callable(progress):
        raise TypeError(f"progress: got {progress!r}, expected a function")
    if environment is not None and not isinstance(environment, Environment):
        raise TypeError(f"environment: got {environment!r}, expected an Environment")
    behind = isinstance(background, str)
    if behind and background != "environment":
        raise TypeError(f"background: got {background!r}, expected numbers or 'environment'")
    if behind and environment is None:
        raise ValueError("background: got 'environment', expected numbers where there is no environment")
    picture, _ = _drawing(scene).render(
        scene._texture_store(),
        _camera(scene, camera, size),
        _lights(scene, lights),
        image_size(size),
        _sampling(filter, max_anisotropy, lod_bias, threads),
        filter == "file",
        None if environment is None else environment._native,
        (0.0, 0.0, 0.0, 0.0) if behind else _background(background),
        behind,
        None if shadows is None else (count("shadows", shadows), number("shadow_softness", shadow_softness)),
        bool(bump_curvature),
        number("displacement_edge", displacement_edge),
        count("supersample", supersample),
        None if debug is None else name("debug", debug),
        False,
        output == "linear",
        progress,
    )
    return picture


def _lights(scene: Scene, lights: Iterable[Light] | None) -> list[Any] | None:
    given = scene.lights if lights is None else lights
    return None if given is None else [to_parts(light) for light in given]


def right_size(
    scene: Scene,
    camera: Camera | str = "auto",
    size: tuple[SupportsIndex, SupportsIndex] = (640, 480),
    *,
    threads: SupportsIndex | None = None,
) -> list[TextureUse]:
    """What resolution of its textures a view uses; textures that it does not read are not listed.

    Parameters
    ----------
    scene, camera, size, threads
        As in :func:`render`.

    Raises
    ------
    ValueError, TypeError, OSError
        As :func:`render` does.

    Examples
    --------
    A texture of 256 by 256 on a square of some 100 by 100 pixels:

    >>> import numpy as np, multum as mt
    >>> square = [[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]]
    >>> mesh = mt.Mesh.build(
    ...     square, [[0, 3, 2], [0, 2, 1]], uv=[[0, 0], [1, 0], [1, 1], [0, 1]],
    ...     texture=np.zeros((256, 256), np.uint8),
    ... )
    >>> use = mt.right_size(mt.Scene(mesh), mt.Camera((0, 0, 3)), (120, 120))[0]
    >>> use.touched, use.histogram[:2], use.recommended
    (1.0, [0, 0], (128, 128))
    """
    _, uses = _drawing(scene).render(
        scene._texture_store(),
        _camera(scene, camera, size),
        _lights(scene, None),
        image_size(size),
        _sampling("nearest", 1, 0.0, threads),
        False,
        None,
        (0.0, 0.0, 0.0, 0.0),
        False,
        None,
        False,
        4.0,
        1,
        None,
        True,
        True,
        None,
    )
    return [TextureUse(*use) for use in uses]
