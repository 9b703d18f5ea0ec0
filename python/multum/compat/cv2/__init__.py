"""OpenCV's image warps: the same names, signatures, flags, defaults and rules, without OpenCV.

Every function that resamples takes ``antialias``. With ``False`` it is OpenCV 5's plain interpolation: equal
within one step of integers and the rounding of floats. With ``True``, the default, it is the same where the map
magnifies; where a pixel covers more than a pixel of the input, it is the filtered value, so that reductions do
not alias. ``INTER_NEAREST`` is never filtered: labels have no average.

Beyond OpenCV: images of any size and number of channels, ``float64`` maps, ``float16`` images.
"""

from . import fisheye
from ._arrays import error
from ._constants import (
    ALGO_HINT_ACCURATE,
    ALGO_HINT_APPROX,
    ALGO_HINT_DEFAULT,
    BORDER_CONSTANT,
    BORDER_DEFAULT,
    BORDER_ISOLATED,
    BORDER_REFLECT,
    BORDER_REFLECT101,
    BORDER_REFLECT_101,
    BORDER_REPLICATE,
    BORDER_TRANSPARENT,
    BORDER_WRAP,
    CV_8S,
    CV_8U,
    CV_16S,
    CV_16SC2,
    CV_16U,
    CV_32F,
    CV_32FC1,
    CV_32FC2,
    CV_32S,
    CV_64F,
    INTER_AREA,
    INTER_BITS,
    INTER_BITS2,
    INTER_CUBIC,
    INTER_LANCZOS4,
    INTER_LINEAR,
    INTER_LINEAR_EXACT,
    INTER_MAX,
    INTER_NEAREST,
    INTER_NEAREST_EXACT,
    INTER_TAB_SIZE,
    INTER_TAB_SIZE2,
    WARP_FILL_OUTLIERS,
    WARP_INVERSE_MAP,
    WARP_POLAR_LINEAR,
    WARP_POLAR_LOG,
    WARP_RELATIVE_MAP,
)
from ._integral import integral, integral2, integral3
from ._pyramids import buildPyramid, pyrDown, pyrUp
from ._remap import convertMaps, remap
from ._resize import resize
from ._undistort import initUndistortRectifyMap, undistort
from ._warps import getRectSubPix, warpAffine, warpPerspective, warpPolar

__all__ = [
    "ALGO_HINT_ACCURATE",
    "ALGO_HINT_APPROX",
    "ALGO_HINT_DEFAULT",
    "BORDER_CONSTANT",
    "BORDER_DEFAULT",
    "BORDER_ISOLATED",
    "BORDER_REFLECT",
    "BORDER_REFLECT101",
    "BORDER_REFLECT_101",
    "BORDER_REPLICATE",
    "BORDER_TRANSPARENT",
    "BORDER_WRAP",
    "CV_8S",
    "CV_8U",
    "CV_16S",
    "CV_16SC2",
    "CV_16U",
    "CV_32F",
    "CV_32FC1",
    "CV_32FC2",
    "CV_32S",
    "CV_64F",
    "INTER_AREA",
    "INTER_BITS",
    "INTER_BITS2",
    "INTER_CUBIC",
    "INTER_LANCZOS4",
    "INTER_LINEAR",
    "INTER_LINEAR_EXACT",
    "INTER_MAX",
    "INTER_NEAREST",
    "INTER_NEAREST_EXACT",
    "INTER_TAB_SIZE",
    "INTER_TAB_SIZE2",
    "WARP_FILL_OUTLIERS",
    "WARP_INVERSE_MAP",
    "WARP_POLAR_LINEAR",
    "WARP_POLAR_LOG",
    "WARP_RELATIVE_MAP",
    "buildPyramid",
    "convertMaps",
    "error",
    "fisheye",
    "getRectSubPix",
    "initUndistortRectifyMap",
    "integral",
    "integral2",
    "integral3",
    "pyrDown",
    "pyrUp",
    "remap",
    "resize",
    "undistort",
    "warpAffine",
    "warpPerspective",
    "warpPolar",
]
