// The film of one frame: two independent halves (estimators.md section 2),
// each with the sums of A (contributions, RGB) and B (weights) per pixel.
#ifndef REFRAME_IMAGE_FILM_H
#define REFRAME_IMAGE_FILM_H

#include <stddef.h>
#include <stdint.h>

typedef struct RfFilm
{
    int width, height;
    double* half[2];    // 4 per pixel: A red, green, blue, B; doubles, for a million passes
    int passes[2];      // passes summed up in each half
    uint64_t landed;    // samples that fell into the film
} RfFilm;

typedef enum RfFilmCombine
{
    RF_FILM_CROSSFIT, // (E2)
    RF_FILM_RATIO,    // A / B
    RF_FILM_PLAIN,    // A
} RfFilmCombine;

static inline size_t rf_film_half_bytes( int width, int height )
{
    return (size_t)width * (size_t)height * 4 * sizeof( double );
}

// The image of the film: rgb (3 per pixel), and the mean of B over the passes
// in `weight` (1 per pixel; may be NULL). A pixel without weight is black.
void rf_combine_film( const RfFilm* film, RfFilmCombine combine, float* rgb, float* weight );

// relMSE of `rgb`, the combined film, against the truth, estimated from the
// difference of the halves; NaN where one of them is empty.
double rf_estimate_relmse( const RfFilm* film, RfFilmCombine combine, const float* rgb );

#endif
