"""Search: which triangles may meet? Trees of boxes and voxels.

=================  ==========================================================  ==============
file               question                                                    source
=================  ==========================================================  ==============
`tree`             which triangles are near? trees of boxes
`tree_tops`        which of many trees can meet at all?
`voxels`           which triangles are near? equal voxels                      Lo & Wang 2004
`separation`       which neighbours surely meet in common corners only?        plane between
`large_triangles`  the same beside triangles that are far wider than others
`vertex_fans`      which triangles around a vertex are seen in one direction?
`rays`             what does a ray along an axis meet first?
=================  ==========================================================  ==============
"""
