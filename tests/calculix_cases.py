"""A test that CalculiX is given, and files that it leaves."""

from studies.benchmarks.calculix_deck import CalculixTest

DAT = """
 displacements (vx,vy,vz) for set HOLDER and time  0.2000000E+01

      4256  1.000000E-03  0.000000E+00 -9.200000E-04

 total force (fx,fy,fz) for set LOWERGRIP and time  0.2000000E+01

        1.240000E+00  0.000000E+00  2.000000E+00
"""

STA = """SUMMARY OF JOB INFORMATION
  STEP      INC     ATT  ITRS     TOT TIME     STEP TIME      INC TIME
     1          1     1     6  0.100000E+01  0.100000E+01  0.100000E+01
     2          1     1     4  0.200000E+01  0.100000E+01  0.100000E+01
     3          1     1U    9  0.225000E+01  0.250000E+00  0.250000E+00
     3          1     2     5  0.206250E+01  0.625000E-01  0.625000E-01
"""


def sliding(rig: float | str = 167.0) -> CalculixTest:
    return CalculixTest(2.0, 9e-4, 0.02, 4, 6, 0.62, "rigid" if rig == "rigid" else float(rig), 210_000.0, 0.3)
