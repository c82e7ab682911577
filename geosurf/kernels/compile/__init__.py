"""How kernels are compiled, cached and called; this room contains no kernel.

=================  ===============================================================
file               content
=================  ===============================================================
`file_cache`       the folder of compiled kernels; cached files, verified before use
`gate`             signatures of kernels, the check in front of each call; plain Python
                   the source files of the kernels
`jit`              the two decorators, and the choice of what runs the kernels; memory kept
`numba_runner`     kernels compiled by numba, and cached
`frozen_runner`    kernels from a precompiled library, without numba
`helpers`          helpers of kernels under numba; the options of numba
`warmup`           ``geosurf warmup``: compile all kernels ahead of time
`freeze`           all kernels as a library, when a wheel is built
`object_files`     kernels as one LLVM module, and its object files
`platforms`        platforms that kernels are frozen for; C functions that call them
=================  ===============================================================
"""
