"""A Dataset without xarray: what reports and writers ask of a table.

Importing xarray takes longer than all tables of a report. Functions for users return the Dataset
that `to_xarray` makes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray


class Column(NamedTuple):
    """A variable; its attributes have the names that they have in xarray."""

    dims: tuple[str, ...]
    values: np.ndarray
    attrs: dict[str, Any]


@dataclass(frozen=True, eq=False)
class PlainDataset:
    """
    Variables and coordinates over named dimensions.

    Attributes
    ----------
    data_vars, coords : dict of Column
    attrs : dict

    Examples
    --------
    >>> areas = {"area": ("pair", [1.0, 2.0], {"units": "m2"})}
    >>> table = PlainDataset.of(areas, {"kind": ("pair", ["a", "b"])}, {"fault": "F1"})
    >>> table.area.values.tolist(), table["kind"].dims, table.sizes
    ([1.0, 2.0], ('pair',), {'pair': 2})
    >>> table.to_xarray().area.attrs
    {'units': 'm2'}
    """

    data_vars: dict[str, Column]
    coords: dict[str, Column]
    attrs: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        data_vars: Mapping[str, Any],
        coords: Mapping[str, Any] | None = None,
        attrs: Mapping[str, Any] | None = None,
    ) -> PlainDataset:
        """Make one from tuples as `xarray.Dataset` takes them: dimension, values, attributes."""
        return cls(
            {name: _column(*parts) for name, parts in data_vars.items()},
            {name: _column(*parts) for name, parts in (coords or {}).items()},
            dict(attrs or {}),
        )

    @property
    def sizes(self) -> dict[str, int]:
        """Length of each dimension."""
        columns = (*self.data_vars.values(), *self.coords.values())
        return {d: n for one in columns for d, n in zip(one.dims, one.values.shape, strict=True)}

    def __getitem__(self, name: str) -> Column:
        found = self.data_vars.get(name) or self.coords.get(name)
        if found is None:
            raise KeyError(name)
        return found

    def __getattr__(self, name: str) -> Column:
        # only for names that are no attribute; underscores are those of copying and pickling
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"there is no variable {name!r}") from None

    def assign_attrs(self, **attrs: Any) -> PlainDataset:
        """Return the same with further attributes."""
        return PlainDataset(self.data_vars, self.coords, self.attrs | attrs)

    def to_xarray(self) -> xarray.Dataset:
        """Return the same as a Dataset, which is made once."""
        return self._dataset

    @cached_property
    def _dataset(self) -> xarray.Dataset:
        import xarray

        return xarray.Dataset(dict(self.data_vars), coords=dict(self.coords), attrs=self.attrs)


def _column(
    dims: str | tuple[str, ...], values: Any, attrs: Mapping[str, Any] | None = None
) -> Column:
    dims = (dims,) if isinstance(dims, str) else dims
    return Column(dims, np.asarray(values), dict(attrs or {}))
