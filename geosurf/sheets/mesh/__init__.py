"""Heights and cut links -> a torn mesh that its faults close, exactly.

=================  ===============================================================================
build.py           attempts to close a sheet, until nothing leaks: start here
                   further rings of ghosts, where a sheet does not reach its fault yet
                   what to change where a sheet leaks: end tears earlier, or add a ring
close.py           a sheet without holes: planned or searched, with its last links
tear_ends.py       faults that end too early, and throw that is lost where tears end
torn_mesh.py       the mesh torn by virtual nodes (Molino, Bao & Fedkiw 2004)
ghosts.py          heights of ghosts: each sheet extended beyond the fault by its own energy
                   ghosts of picked sheets: by the energy, and by picks beyond the trace
cut.py             the exact cut of a torn mesh by its faults
finish.py          faults in, `Sheet` out; errors of sheets that do not close
                   ghosts of overlapping sheets from scattered points
=================  ===============================================================================
"""
