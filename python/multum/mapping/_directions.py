"""Maps of directions."""

from typing import ClassVar, SupportsFloat

from .. import _multum
from ._map import Invertible
from ._numbers import single


class _Direction(Invertible):
    _kind: ClassVar[str]

    def __init__(self) -> None:
        """See the class."""
        super().__init__(_multum.Mapping.direction(self._kind))


class SphereMap(_Direction):
    """OpenGL's sphere map of a reflected direction in eye space (x right, y up, +z towards the viewer).

    u = r_x/m + 1/2, v = 1/2 - r_y/m, m = 2 sqrt(r_x² + r_y² + (r_z + 1)²). At the rim, straight away from
    the viewer, the Jacobian is infinite.

    >>> SphereMap()([0.0, 0.0, 1.0]).tolist()
    [0.5, 0.5]
    """

    _kind = "sphere_map"


class LightProbe(_Direction):
    """The angular map: the angle from forward (+z) is the distance from the centre; the rim is backward.

    >>> LightProbe()([1.0, 0.0, 0.0]).tolist()
    [0.75, 0.5]
    """

    _kind = "light_probe"


class MirrorBall(_Direction):
    """The photograph of a mirror ball, the camera looking forward (+z): centre backward, rim forward.

    >>> MirrorBall()([0.0, 0.0, -1.0]).tolist()
    [0.5, 0.5]
    """

    _kind = "mirror_ball"


class Equirect(_Direction):
    """The equirectangular panorama: forward (+z) at the centre, right (+x) at u = 3/4, up (+y) at v = 0.

    >>> Equirect()([1.0, 0.0, 0.0]).tolist()
    [0.75, 0.5]
    """

    _kind = "equirect"


class DualParaboloid(_Direction):
    """Two discs side by side: forward directions on the left, backward ones on the right.

    >>> DualParaboloid()([0.0, 0.0, -1.0]).tolist()
    [0.75, 0.5]
    """

    _kind = "dual_paraboloid"


class Octahedral(_Direction):
    """The octahedron unfolded to a square: forward at the centre, backward at the four corners.

    >>> Octahedral()([1.0, 0.0, 0.0]).tolist()
    [1.0, 0.5]
    """

    _kind = "octahedral"


class Stereographic(Invertible):
    """The stereographic picture, ``fov`` degrees wide: tan(theta/2) from the centre (forward). Keeps angles.

    >>> Stereographic(180)([1.0, 0.0, 0.0]).round(12).tolist()
    [1.0, 0.5]
    """

    def __init__(self, fov: SupportsFloat = 180.0) -> None:
        """See the class."""
        super().__init__(_multum.Mapping.stereographic(single("fov", fov)))


class Fisheye(Invertible):
    """A round picture ``fov`` degrees wide: ``"equidistant"`` (angle) or ``"equisolid"`` (sin of its half).

    >>> Fisheye(fov=180)([1.0, 0.0, 1.0]).tolist()
    [0.75, 0.5]
    """

    def __init__(self, model: str = "equidistant", fov: SupportsFloat = 180.0) -> None:
        """See the class."""
        super().__init__(_multum.Mapping.fisheye(model, single("fov", fov)))


class Perspective(Invertible):
    """A pinhole camera that looks forward, ``fov`` degrees across, ``aspect`` = width / height.

    >>> Perspective(90)([1.0, 0.0, 2.0]).round(12).tolist()
    [0.75, 0.5]
    """

    def __init__(self, fov: SupportsFloat = 90.0, aspect: SupportsFloat = 1.0) -> None:
        """See the class."""
        super().__init__(_multum.Mapping.perspective(single("fov", fov), single("aspect", aspect)))
