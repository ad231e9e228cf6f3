// Cosine transform of an image with Neumann borders, which diagonalises the system with constant weights
// (FFTW, DCT-II and its inverse).
#ifndef REFRAME_GRADIENT_TRANSFORM_H
#define REFRAME_GRADIENT_TRANSFORM_H

#include "reframe/error.h"

#include <stddef.h>

typedef struct RfCosineTransform
{
    int width, height;
    void *forward, *backward; // plans of FFTW
    double* eigenvalues;      // of Dxᵀ Dx, one per column
} RfCosineTransform;

// Plans transforms of width·height floats in place. Any thread may call it. The plan depends on the size alone
// (FFTW_ESTIMATE). `plane` is any plane, which is not changed. Fails with RF_ERROR_MEMORY.
RfResult rf_create_transform( int width, int height, float* plane, RfCosineTransform* transform, RfError* error );

// Frees the plans. Takes an empty struct.
void rf_destroy_transform( RfCosineTransform* transform );

// Solves (a + b_x Dxᵀ Dx + b_y Dyᵀ Dy) u = r in place, for constant weights, a > 0. `plane` is aligned as the one of the
// plan. Several threads may use one transform.
void rf_solve_constant( const RfCosineTransform* transform, double a, double b_x, double b_y, float* plane );

#endif
