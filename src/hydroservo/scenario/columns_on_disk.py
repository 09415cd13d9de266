"""A table whose columns are read from parts on disk when they are asked for, one at a time."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.core import indexing

from hydroservo.work.store import Store


def table_on_disk(
    store: Store, keys: Sequence[str], index: str, rows: int, about: Mapping[str, Any]
) -> xr.Dataset:
    """The parts of a store as one table, of which nothing is in memory.

    Each use of a column reads it anew: memory holds what is in use.

    Args:
        store: where the parts are.
        keys: of the parts, in order; all of them are done.
        index: the column of the number of a row, 0 to rows - 1, along which the others are.
        rows: of all parts.
        about: attributes of the table.
    """
    schema = store.read(keys[0]).schema
    columns = {
        field.name: xr.Variable(
            (index,),
            indexing.LazilyIndexedArray(StoredColumn(store, keys, field.name, rows, numpy_kind(field.type))),
            decode_metadata(field.metadata),
        )
        for field in schema
        if field.name != index
    }
    return xr.Dataset(columns, attrs=dict(about))


class StoredColumn(BackendArray):
    """A column of a store's parts, as xarray reads what is on disk."""

    def __init__(
        self, store: Store, keys: Sequence[str], name: str, rows: int, kind: "np.dtype[Any]"
    ) -> None:
        self.store, self.keys, self.name = store, keys, name
        self.shape, self.dtype = (rows,), kind

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.VECTORIZED, self.rows
        )

    def rows(self, key: Any) -> NDArray[Any]:
        """Some rows of it."""
        found = self.store.table(self.keys, [self.name]).column(self.name).to_numpy()
        chosen: NDArray[Any] = found.astype(self.dtype, copy=False)[key]
        return chosen


def numpy_kind(arrow: Any) -> "np.dtype[Any]":
    """Which numpy type a column of Arrow is read as."""
    kind: np.dtype[Any] = np.dtype(arrow.to_pandas_dtype())
    return kind


def decode_metadata(metadata: Mapping[bytes, bytes] | None) -> dict[str, str]:
    return {name.decode(): text.decode() for name, text in (metadata or {}).items()}
