"""How kernels are compiled, kept and called; no kernel is in here.

===================  ===========================================================
file                 what is in it
===================  ===========================================================
`cache_folder`       where compiled kernels are kept
`freeze`             all kernels into a library, when a wheel is built
`frozen_runner`      kernels from that library, without numba
`gate`               letters of a signature, and the check in front of each call
`helpers`            helpers of kernels under numba
`jit`                the two decorators, and what runs the kernels
`numba_runner`       kernels compiled by numba, and kept
`object_files`       kernels as one module of LLVM, and its object files
`memory_pages`       memory that one call gives back serves the next
`plain_runner`       kernels as plain Python
`file_cache`         files that are checked before they are used
`sources`            where the sources of the kernels lie
`warmup`             ``geosurf warmup``
`written_arguments`  which arguments does a kernel write?
===================  ===========================================================
"""
