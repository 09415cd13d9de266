"""Rules of MISRA C:2012 that exported C does not follow, by number, and why."""

DEVIATIONS = {
    "2.5": "Scenario and version stand in macros of the header for the program around it alone.",
    "8.9": "Inlined parameters stand together at the top of the source, even where one function alone "
    "reads them.",
    "19.2": "The bits of a number are read and made through a union of types of one size, as C99 allows.",
}
