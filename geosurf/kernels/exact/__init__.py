"""Exact arithmetic: signs of determinants, and points that are defined by what constructs them.

====================  ====================================================  =================
file                  question                                              source
====================  ====================================================  =================
`bigint`              How are integers of any length added and multiplied?  schoolbook method
`exact_signs`         What is the exact sign? Where is the rounded point?   Attene 2020
`predicates`          On which side does a point lie? Float filter first.   Shewchuk 1997
                      Which points lie inside which segments?
`constructed_points`  Which id does a constructed point have?               Levy 2024
                      Where is a constructed point, to 104 bits?            Dekker 1971
====================  ====================================================  =================
"""
