// Kronecker sequences over passes, pixels and frames: word + k α + x β + y γ + f δ modulo 1 in each coordinate, as a fraction of 32
// bits (additive recurrences, Richtmyer 1951; Cranley, Patterson, SIAM J. Numer. Anal. 13(6), 1976). With a random word each number by
// itself is uniform, and the numbers of the passes of a pixel, of the pixels of a tile and of the frames of a group are stratified,
// each of these sets by itself and all together. The word is that of a block of pixels, so that errors of different blocks are
// independent. src/reuse/estimators.md, section 24.
#ifndef REFRAME_BASE_LATTICE_H
#define REFRAME_BASE_LATTICE_H

#include <stdint.h>

// Numbers that multiply each other in a path have different coordinates, or one would always come with the same of the other.
typedef enum RfLatticeCoordinate
{
    RF_LATTICE_DIRECTION, // two, or of a point on a light
    RF_LATTICE_CHOICE = 2,
    RF_LATTICE_FILM, // two
    RF_LATTICE_COAT = 5,
    RF_LATTICE_CHAIN,
    RF_LATTICE_SIDE,
    RF_LATTICE_LENS, // three
    RF_LATTICE_COORDINATES = 11,
} RfLatticeCoordinate;

#define RF_LATTICE_BLOCK 16u // pixels across

typedef struct RfLatticeSteps
{
    uint32_t pass, x, y, frame;
} RfLatticeSteps;

// The first five were found by a search for the least error in the worst case of integrals over them (Korobov spaces, randomly
// shifted), of 4 to 64 passes, windows of 2×2 to 4×4 pixels, 2 to 7 frames, and of their products. The others are quadratic
// irrationals and the R sequences of M. Roberts (The Unreasonable Effectiveness of Quasirandom Sequences, 2018). Lenses have no pixel.
static const RfLatticeSteps rf_lattice_steps[RF_LATTICE_COORDINATES] = {
    { 0x88627617u, 0xe42f38a7u, 0x43687b95u, 0x492a698bu },
    { 0xb63da959u, 0x9d69d9b9u, 0x1c913923u, 0xb62457cfu },
    { 0x1e9f91d7u, 0xbf3f7231u, 0xd0396f8du, 0x49db4003u },
    { 0xce52a311u, 0x144bd139u, 0x5655a5cfu, 0x925ccbb3u },
    { 0x5ec2c537u, 0x924ca8d1u, 0x5c6fd5d1u, 0x22f54009u },
    { 0x9e3779b9u, 0xc13fa9a9u, 0x91e10da5u, 0x6a09e667u },
    { 0x6a09e667u, 0xdb4f0b91u, 0xbbe05633u, 0xa0f2ec75u },
    { 0x4d82b447u, 0xd1b54a33u, 0xabc98389u, 0x8cb92ba7u },
    { 0xd1b54a33u, 0, 0, 0xbb67ae85u },
    { 0xabc98389u, 0, 0, 0x3c6ef373u },
    { 0x8cb92ba7u, 0, 0, 0xa54ff53bu },
};

#endif
