"""Meshes: welding, edges, parts, chains, orders and volumes, by integer keys.

==============  ============================================  ===============
file            question                                      source
==============  ============================================  ===============
`mesh`          welding, edges, patches
`radial_order`  in which order are triangles around an edge?  Weiler 1985
`parts`         what hangs together -> cells
`volumes`       volume below faces, area and bounds           Knuth's two-sum
`polylines`     curves -> segments
`chains`        segments -> curves
`linking`       segments that cannot overlap
`ranking`       places and segments in one order
`numbering`     a few keys out of many, numbered
==============  ============================================  ===============
"""
