"""Arrays of other libraries as torch and jax have them, without either library.

A tensor that requires gradients or sits on a device refuses numpy with torch's own errors, until
`detach` and `cpu` were called.
"""

from __future__ import annotations

import numpy as np


class Tensor:
    """As `torch.Tensor`: numpy reads it only without gradients and on the processor."""

    def __init__(self, values, *, requires_grad=True, device="cuda:0", dtype="float64"):
        self.values = np.asarray(values)
        self.requires_grad, self.device, self.dtype = requires_grad, device, dtype

    def _changed(self, **changes):
        kept = {"requires_grad": self.requires_grad, "device": self.device, "dtype": self.dtype}
        return Tensor(self.values, **kept | changes)

    @property
    def shape(self):
        return self.values.shape

    @property
    def ndim(self):
        return self.values.ndim

    def __len__(self):
        return len(self.values)

    def __getitem__(self, index):
        return Tensor(self.values[index], requires_grad=self.requires_grad, device=self.device)

    def detach(self):
        return self._changed(requires_grad=False)

    def cpu(self):
        if self.device == "meta":
            raise NotImplementedError("Cannot copy out of meta tensor; no data!")
        return self._changed(device="cpu")

    def float(self):
        return self._changed(dtype="float32")

    def numpy(self):
        if self.requires_grad:
            raise RuntimeError(
                "Can't call numpy() on Tensor that requires grad. Use tensor.detach().numpy() "
                "instead."
            )
        if self.device != "cpu":
            raise TypeError(f"can't convert {self.device} device type tensor to numpy.")
        if self.dtype == "bfloat16":
            raise TypeError("Got unsupported ScalarType BFloat16")
        return self.values

    def __array__(self, dtype=None, copy=None):
        return self.numpy() if dtype is None else self.numpy().astype(dtype)

    def __dlpack__(self, **_):
        raise BufferError("Can't export tensors that require gradient")


class JaxArray:
    """As `jax.Array`: an array that is none of numpy's, its numbers no `numbers.Real`."""

    def __init__(self, values):
        self.values = np.asarray(values)

    shape = property(lambda self: self.values.shape)
    ndim = property(lambda self: self.values.ndim)

    def __len__(self):
        return len(self.values)

    def __getitem__(self, index):
        return JaxArray(self.values[index])

    def __array__(self, dtype=None, copy=None):
        return self.values if dtype is None else self.values.astype(dtype)


class OnlyDlpack:
    """An array that gives its memory and nothing else."""

    def __init__(self, values):
        self.values = np.asarray(values)

    def __dlpack__(self, **options):
        return self.values.__dlpack__(**options)

    def __dlpack_device__(self):
        return self.values.__dlpack_device__()
