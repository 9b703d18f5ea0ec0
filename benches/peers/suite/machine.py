"""What it runs on: processor, versions, memory."""

import importlib
import os
import platform
import time
from pathlib import Path
from typing import Any

import numpy as np

PACKAGES = {
    "OpenCV": "cv2",
    "scikit-image": "skimage",
    "SciPy": "scipy",
    "Pillow": "PIL",
    "reproject": "reproject",
    "py360convert": "py360convert",
    "OpenImageIO": "OpenImageIO",
    "moderngl": "moderngl",
    "NumPy": "numpy",
}


def cpu() -> str:
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def versions() -> dict[str, str]:
    """Versions of the packages that can be imported."""
    found = {}
    for name, module in PACKAGES.items():
        try:
            found[name] = str(getattr(importlib.import_module(module), "__version__", "?"))
        except Exception:
            continue
    return found


def copy_bandwidth() -> float:
    """Bytes a second that one thread copies: the best of ten copies of 128 MB, read and written bytes together."""
    source = np.ones(1 << 27, np.uint8)
    target = np.empty_like(source)
    best = np.inf
    for _ in range(10):
        start = time.thread_time()
        np.copyto(target, source)
        best = min(best, time.thread_time() - start)
    return 2 * source.nbytes / best


def describe() -> dict[str, Any]:
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan")
    return {
        "cpu": cpu(),
        "cores": os.cpu_count(),
        "load": round(load, 1),
        "simd": os.environ.get("MULTUM_SIMD", "best"),
        "python": platform.python_version(),
        "versions": versions(),
        "copy": copy_bandwidth(),
    }
