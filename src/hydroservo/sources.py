"""Where numbers come from, named once."""

__all__ = ["CHOSEN", "DATASHEET", "TSMC_EHA_2021"]

TSMC_EHA_2021 = "doi:10.1007/s42401-021-00087-w, Sec. 4"
CHOSEN = "chosen here"
DATASHEET = "datasheet"
