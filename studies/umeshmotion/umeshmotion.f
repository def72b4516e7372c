C     The energy wear law as a user subroutine of Abaqus/Standard, for decks that `wirewear export --as-deck` writes.
C     A node of the set that *ADAPTIVE MESH CONSTRAINT names recedes along its normal by half of
C         (alpha / 1000) . jump . tau . slip,
C     tau in MPa, slip in mm, alpha in mm3/J of both bodies, jump in cycles that one cycle of the deck stands for.
C     It was compiled; it was not run in Abaqus.
      SUBROUTINE UMESHMOTION(UREF, ULOCAL, NODE, NNDOF, LNODETYPE, ALOCAL, NDIM, TIME, DTIME, PNEWDT, KSTEP, KINC,
     1    KMESHSWEEP, JMATYP, JGVBLOCK, LSMOOTH)
      IMPLICIT NONE
      INTEGER NODE, NNDOF, LNODETYPE, NDIM, KSTEP, KINC, KMESHSWEEP, JMATYP(*), JGVBLOCK(*), LSMOOTH
      DOUBLE PRECISION UREF, ULOCAL(NDIM), ALOCAL(NDIM, *), TIME(2), DTIME, PNEWDT
      INTEGER MOST, JRCD
      PARAMETER (MOST = 1000000)
      DOUBLE PRECISION ALPHA, JUMP, SHARE
      PARAMETER (ALPHA = 3.0D-5, JUMP = 100.0D0, SHARE = 0.5D0)
      DOUBLE PRECISION STRESS(15), MOVED(15), SLIP, SHEAR, BEFORE(2, MOST)
      SAVE BEFORE
      DATA BEFORE /2000000 * 0.0D0/
      IF (KMESHSWEEP .GT. 0 .OR. NODE .GT. MOST) RETURN
      CALL GETVRN(NODE, 'CSTRESS', STRESS, JRCD, JGVBLOCK, 0)
      IF (JRCD .NE. 0) RETURN
      CALL GETVRN(NODE, 'CDISP', MOVED, JRCD, JGVBLOCK, 0)
      IF (JRCD .NE. 0) RETURN
C     COPEN is followed by the accumulated slip along both tangents.
      SLIP = SQRT((MOVED(2) - BEFORE(1, NODE))**2 + (MOVED(3) - BEFORE(2, NODE))**2)
      BEFORE(1, NODE) = MOVED(2)
      BEFORE(2, NODE) = MOVED(3)
      SHEAR = SQRT(STRESS(2)**2 + STRESS(3)**2)
      IF (STRESS(1) .LE. 0.0D0 .OR. DTIME .LE. 0.0D0) RETURN
      ULOCAL(NDIM) = ULOCAL(NDIM) - SHARE * 1.0D-3 * ALPHA * JUMP * SHEAR * SLIP / DTIME
      END
