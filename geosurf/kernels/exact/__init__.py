"""Exact arithmetic: signs of determinants and points that are known by what makes them.

====================  =================================================  ========================
file                  question                                           source
====================  =================================================  ========================
`bigint`              exact integers of any length                       schoolbook, 26-bit limbs
`exact_signs`         exact signs and correctly rounded points           Attene 2020
`predicates`          on which side is it? filter first                  Shewchuk 1997
`double_double`       constructed points in double-double, with a bound  Dekker 1971
`constructed_points`  one id per point, whatever it is called            Levy 2024
`collinear`           which points lie inside which segments?
====================  =================================================  ========================
"""
