"""A CUDA device: memory on it and kernels of PTX, through NVIDIA's own Python bindings of its driver."""

from collections.abc import Sequence
from functools import cache
from typing import Any
from weakref import finalize

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.errors import ParameterError

try:
    from cuda.bindings import driver
except ImportError:  # of the extra
    driver = None


class DeviceMemory:
    """Numbers of eight bytes on the device, freed with the last reference to them."""

    def __init__(self, numbers: NDArray[Any]) -> None:
        self.kind, self.size = numbers.dtype, numbers.size
        self.address = int(driver_result(driver.cuMemAlloc(numbers.nbytes)))
        finalize(self, driver.cuMemFree, self.address).atexit = False  # the driver is gone by then
        driver_result(driver.cuMemcpyHtoD(self.address, numbers.ctypes.data, numbers.nbytes))

    def read(self, first: int = 0, last: int | None = None) -> NDArray[Any]:
        """Numbers first to last-1, here."""
        found = np.empty((self.size if last is None else last) - first, self.kind)
        start = self.address + first * found.itemsize
        driver_result(driver.cuMemcpyDtoH(found.ctypes.data, start, found.nbytes))
        return found


class DeviceKernel:
    """A function of PTX, compiled for the device by its driver."""

    def __init__(self, code: bytes, name: str) -> None:
        self.module = driver_result(driver.cuModuleLoadData(code + b"\0"))
        self.function = driver_result(driver.cuModuleGetFunction(self.module, name.encode()))

    def launch(self, blocks: int, threads: int, arguments: Sequence[NDArray[Any]]) -> None:
        """Runs blocks of threads, and waits for them."""
        places = np.array([argument.ctypes.data for argument in arguments], dtype=np.uint64)
        size, shared, stream, extra = (blocks, 1, 1, threads, 1, 1), 0, 0, 0
        driver_result(driver.cuLaunchKernel(self.function, *size, shared, stream, places.ctypes.data, extra))
        driver_result(driver.cuCtxSynchronize())

    def spilled_bytes(self) -> int:
        """The bytes of memory that a thread needs for what its registers do not hold."""
        size = driver.CUfunction_attribute.CU_FUNC_ATTRIBUTE_LOCAL_SIZE_BYTES
        return int(driver_result(driver.cuFuncGetAttribute(size, self.function)))

    def resident(self, threads: int) -> int:
        """How many threads, in blocks of so many, the whole device runs at once."""
        blocks = driver_result(driver.cuOccupancyMaxActiveBlocksPerMultiprocessor(self.function, threads, 0))
        return int(blocks) * device().multiprocessors * threads


class Device:
    """The first device, in use by this thread.

    Raises:
        ParameterError: the bindings, the driver or a device is missing.
    """

    def __init__(self) -> None:
        if driver is None:
            raise ParameterError(
                "cuda", True, "cuda-bindings is missing; pip install 'hydroservo[cuda]' brings it"
            )
        try:
            driver_result(driver.cuInit(0))
        except RuntimeError:  # there is no driver to load
            raise ParameterError("cuda", True, "there is no driver of a CUDA device") from None
        first = driver_result(driver.cuDeviceGet(0))
        self.context = driver_result(driver.cuDevicePrimaryCtxRetain(first))
        count = driver.CUdevice_attribute.CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT
        self.multiprocessors = int(driver_result(driver.cuDeviceGetAttribute(count, first)))

    def use(self) -> None:
        """Makes it the device of this thread."""
        driver_result(driver.cuCtxSetCurrent(self.context))


@cache
def device() -> Device:
    """The device; asked for again while there is none."""
    return Device()


def has_device() -> bool:
    try:
        device()
    except ParameterError:
        return False
    return True


def driver_result(answer: Any) -> Any:
    error, *found = answer
    if error != driver.CUresult.CUDA_SUCCESS:
        _, text = driver.cuGetErrorString(error)
        raise ParameterError("cuda", True, f"the CUDA driver says {(text or b'unknown error').decode()}")
    return found[0] if found else None
