"""Pages have doctests; the scripts of pictures and the configuration of Sphinx have none."""

collect_ignore_glob = ["*.py", "gallery/*.py", "figures/*.py", "_build/*", "generated/*"]
