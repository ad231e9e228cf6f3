"""The colour of a black body, as Cycles' node gives it: linear Rec. 709 of luminance 1."""
import math

# x, y, z of the CIE 1931 observer: weight, peak in nm, widths below and above (Wyman, Sloan, Shirley 2013, JCGT 2(2), table 1)
LOBES = (((1.056, 599.8, 37.9, 31.0), (0.362, 442.0, 16.0, 26.7), (-0.065, 501.1, 20.4, 26.2)),
         ((0.821, 568.8, 46.9, 40.5), (0.286, 530.9, 16.3, 31.1)),
         ((1.217, 437.0, 11.8, 36.0), (0.681, 459.0, 26.0, 13.8)))
FROM_XYZ = ((3.2406, -1.5372, -0.4986), (-0.9689, 1.8758, 0.0415), (0.0557, -0.2040, 1.0570))
SECOND = 0.014388  # hc/k, m K


def observer(lobes, nm):
    return sum(w * math.exp(-0.5 * ((nm - peak) / (below if nm < peak else above)) ** 2) for w, peak, below, above in lobes)


def colour_of(kelvin):
    kelvin = min(max(kelvin, 800.0), 12000.0)  # between which Cycles' colours change
    waves = [(nm, 1.0 / (nm ** 5 * math.expm1(SECOND / (nm * 1e-9 * kelvin)))) for nm in range(380, 781, 5)]
    xyz = [sum(observer(lobes, nm) * light for nm, light in waves) for lobes in LOBES]
    return tuple(max(sum(a * v for a, v in zip(row, xyz)) / xyz[1], 0.0) for row in FROM_XYZ)
