"""Records what PyTorch gives, for tests on machines without it: python tests/python/golden/make_torch.py."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import torch
import torch.nn.functional as functional


def tensor(value: Any) -> Any:
    return torch.from_numpy(value)


def main() -> None:
    rng = np.random.default_rng(2026)
    cases: list[dict[str, Any]] = []
    for mode in ("bilinear", "nearest", "bicubic"):
        for padding_mode in ("zeros", "border", "reflection"):
            for align in (False, True):
                for dtype in (np.float32, np.float64):
                    image = rng.normal(size=(2, 2, 4, 5)).astype(dtype)
                    grid = rng.uniform(-1.7, 1.7, (2, 3, 4, 2)).astype(dtype)
                    a, b = tensor(image).requires_grad_(), tensor(grid).requires_grad_()
                    output = functional.grid_sample(a, b, mode, padding_mode, align)
                    above = rng.normal(size=output.shape).astype(dtype)
                    output.backward(tensor(above))
                    case: dict[str, Any] = {"kind": "grid_sample", "input": image, "grid": grid, "mode": mode}
                    case |= {"padding_mode": padding_mode, "align_corners": align, "grad_output": above}
                    case |= {"output": output.detach().numpy()}
                    cases.append(case | {"grad_input": a.grad.numpy(), "grad_grid": b.grad.numpy()})
    for align in (False, True):
        for shape in ((2, 1, 3, 4), (2, 1, 1, 5)):
            theta = rng.normal(size=(2, 2, 3))
            output = functional.affine_grid(tensor(theta), list(shape), align_corners=align).numpy()
            case = {"kind": "affine_grid", "theta": theta, "size": np.array(shape), "align_corners": align}
            cases.append(case | {"output": output})
    ways: list[dict[str, Any]] = [{"mode": m} for m in ("nearest", "nearest-exact", "area")]
    for mode in ("bilinear", "bicubic"):
        ways += [{"mode": mode, "align_corners": align} for align in (False, True)]
        ways += [{"mode": mode, "antialias": True}, {"mode": mode, "align_corners": True, "antialias": True}]
    sizes: list[dict[str, Any]] = [{"size": (3, 9)}, {"size": (11, 2)}, {"scale_factor": (1.3, 0.45)}]
    for way in ways:
        for size in sizes:
            for dtype in (np.float32, np.float64):
                image = rng.normal(size=(1, 2, 7, 6)).astype(dtype)
                output = functional.interpolate(tensor(image), **size, **way).numpy()
                stored = {name: np.array(value) for name, value in size.items()}
                cases.append({"kind": "interpolate", "input": image, **stored, **way, "output": output})
    # Arrays are [dtype, shape] in the description, and their numbers lie behind one another.
    numbers: list[Any] = []
    for case in cases:
        for name, value in case.items():
            if isinstance(value, np.ndarray):
                numbers.append(value.astype(np.float64).ravel())
                case[name] = [value.dtype.str, *value.shape]
    description = np.array(json.dumps(cases))
    np.savez_compressed(
        Path(__file__).with_name("torch.npz"), description=description, numbers=np.concatenate(numbers)
    )
    print(f"{len(cases)} cases by PyTorch {torch.__version__}")


if __name__ == "__main__":
    main()
