"""How kernels are compiled, cached and called; this room contains no kernel.

=================  ===============================================================
file               content
=================  ===============================================================
`cache_folder`     the folder of compiled kernels
`file_cache`       cached files, verified before use
`sources`          the source files of the kernels
`gate`             signatures of kernels, and the check in front of each call
`jit`              the two decorators, and the choice of what runs the kernels
`plain_runner`     kernels as plain Python
`numba_runner`     kernels compiled by numba, and cached
`frozen_runner`    kernels from a precompiled library, without numba
`helpers`          helpers of kernels under numba; the options of numba
`warmup`           ``geosurf warmup``: compile all kernels ahead of time
`freeze`           all kernels as a library, when a wheel is built
`call_wrappers`    C functions that call frozen kernels
`object_files`     kernels as one LLVM module, and its object files
`platforms`        platforms that kernels are frozen for
`memory_pages`     freed memory stays with the process for the next call
=================  ===============================================================
"""
