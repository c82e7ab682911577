"""Meshes: welding, edges, parts, chains, orders and volumes, by integer keys.

================= ======================================================= ===============
file              question                                                source
================= ======================================================= ===============
`mesh`            Which vertices are equal, which edges shared? Patches.  union-find
`radial_order`    In which order are triangles around an edge?            Weiler 1985
`parts`           Which parts do surfaces have, and at which edges do they end?
`seams`           Which parts face each other around their edges? Cells.
`sheet_parts`     What of a torn sheet do faults part, and on which side of them is it?
`glued_copies`    Which corners of torn triangles are one vertex?         Molino 2004
`volumes`         What are the volume below faces, area and bounds?       Knuth's two-sum
`level_volumes`   What volume of faces is above and below a level?        Knuth's two-sum
`shells`          In which order are triangles? Which edges are open?     Hibbard 1963
`chains`          Which curves do segments form?
`linking`         Which segments of curves cannot overlap?
`numbering`       Which number has each key among the distinct ones?
================= ======================================================= ===============
"""
