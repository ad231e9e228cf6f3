// The film of one frame: two independent halves (src/reuse/estimators.md, section 2),
// each with the sums of A (contributions, RGB) and B (weights) per pixel, and where something moves with those of own-frame
// light (section 18).
//
// A float that many values are added to loses them bit by bit. So what both halves have in common, a mean times the weight of
// their passes, is taken out of the sums after every block of passes: a half holds what it differs from it, and what came since.
// The mean of B is 1, that of A takes 64 bits: 40 bytes a pixel for both halves. Rounding in floats as large as Rmax values takes
// 2^-26 Rmax of a sum of equal ones at most, and n of them in each half leave Rmax = 512 + n / 367,000: 3e-5 of the brightest
// channel for 10^9 additions to a pixel. Where noise sets the halves apart, it takes n 2^-26 of that noise.
#ifndef REFRAME_FILM_FILM_H
#define REFRAME_FILM_FILM_H

#include "base/fault.h"
#include "reframe/render_settings.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct RfFilm
{
    int width, height;
    bool split;       // own-frame light has sums of its own: Aᵒ and Bᵒ of all pixels follow A and B of all
    float* half[2];   // 4 per pixel: A red, green, blue, B, without mean times held
    uint64_t* mean;   // of A and of Aᵒ per weight, packed
    double held[2];   // weight of the passes whose mean has been taken out of a half; 0: none yet
    int block;        // passes of both halves after which it is taken out anew
    int passes[2];    // passes in each half
    double weight[2]; // sum of their weights; its expectation is that of B in a pixel
    uint64_t landed;  // samples that landed in the film
    float* extra[2];  // adaptive sampling: weight of extra samples per pixel, which count like passes there; NULL: none
    float* mean_b;    // the mean of B with them; NULL: 1
    uint64_t extra_samples;
} RfFilm;

// Additions to a pixel of a half after which a mean is taken out of it.
#define RF_FILM_ADDITIONS 512

// Passes of both halves, which alternate, until then, where a pass adds to a pixel about `samples` times.
static inline int rf_film_block( int samples ) { return 2 * ( samples < RF_FILM_ADDITIONS ? RF_FILM_ADDITIONS / samples : 1 ); }

// Aᵒ and Bᵒ of a half; NULL where the film has none.
static inline float* rf_film_own( const RfFilm* film, int half )
{
    return film->split ? film->half[half] + 4 * (size_t)film->width * (size_t)film->height : NULL;
}

// Sums over a film are those of so many parts, which may be summed at once: the same for any number of threads.
#define RF_FILM_PARTS 256

// The first pixel of a part; of part RF_FILM_PARTS, their number.
static inline size_t rf_film_part( const RfFilm* film, int part )
{
    return (size_t)film->width * (size_t)film->height * (size_t)part / RF_FILM_PARTS;
}

void rf_clear_film( RfFilm* film );

// Its two parts: counts and weights; the sums of pixels [first, first + count).
void rf_clear_film_counts( RfFilm* film );
void rf_clear_film_pixels( RfFilm* film, size_t first, size_t count );

// Ends a pass into a half; its samples were added with this weight.
void rf_end_film_pass( RfFilm* film, int half, double weight );

// The image of the film: rgb (3 per pixel), and the mean of B over the passes
// in `weight` (1 per pixel; may be NULL). A pixel without weight is black.
void rf_combine_film( const RfFilm* film, RfNormalize normalize, float* rgb, float* weight );

// The same for pixels [first, first + count) only.
void rf_combine_film_pixels( const RfFilm* film, RfNormalize normalize, size_t first, size_t count, float* rgb, float* weight );

// The image of the first half, 3 of 4 floats per pixel, and its share of the weights; the picture and 1 where there is no other.
void rf_combine_half( const RfFilm* film, RfNormalize normalize, float* half );

// The image of `part`, a film with the sums of some of the light of `film`, whose weights are those of `film`: the images of parts
// add up to that of the film if their sums do (src/reuse/estimators.md, E20). With the light that a clamp has taken out, image and
// part together are the image without a clamp (E15).
void rf_combine_part( const RfFilm* film, const RfFilm* part, RfNormalize normalize, float* rgb );

// The share of the light that films[1] has, removed from films[0], by luminance, 0 to 1. `rgb`: the image of films[0].
double rf_removed_share( const RfFilm* films, RfNormalize normalize, const float* rgb );

// Adds to each pixel of `image` what the mean of its right neighbour, or of the one below, has more than its own: of the halves
// `first` to `last`.
void rf_add_film_steps( const RfFilm* film, int first, int last, bool down, float* image );

// Coverage of the pixels by what camera rays hit, combined like the colour. `sky`: the weight of the rays that missed,
// a plane of pixels for each half.
void rf_combine_alpha( const RfFilm* film, RfNormalize normalize, const float* sky, float* alpha );

// Variance of the pixels of the combined film, 3 channels each, estimated from the difference of
// the halves: unbiased, but noisy, since each pixel has one such difference. 0 where a half
// is empty.
void rf_estimate_variance( const RfFilm* film, RfNormalize normalize, float* variance );

// A pixel of a film in the two halves.
typedef struct RfFilmPixel
{
    double half[2][4];
    double weight[2];
    double extra[2];  // of the weight: that of extra samples, which bring all their light to A
    double own[2][4]; // Aᵒ and Bᵒ; 0 where the film is not split
} RfFilmPixel;

// The mean of A, B in pixel i, or of Aᵒ, Bᵒ in pixel i − width height.
void rf_film_mean( const RfFilm* film, size_t i, double mean[4] );

// The sums of a half there.
static inline void rf_film_sums_at( const RfFilm* film, size_t i, int h, double sums[4] )
{
    double mean[4] = { 0.0 };
    if ( film->held[h] > 0.0 )
        rf_film_mean( film, i, mean );
    for ( size_t c = 0; c < 4; ++c )
        sums[c] = (double)film->half[h][4 * i + c] + film->held[h] * mean[c];
}

static inline RfFilmPixel rf_film_pixel( const RfFilm* film, size_t i )
{
    RfFilmPixel p = { .weight = { film->weight[0], film->weight[1] } };
    for ( int h = 0; h < 2; ++h )
    {
        p.extra[h] = film->extra[h] != NULL ? (double)film->extra[h][i] : 0.0;
        p.weight[h] += p.extra[h];
        rf_film_sums_at( film, i, h, p.half[h] );
        if ( film->split )
            rf_film_sums_at( film, i + (size_t)film->width * (size_t)film->height, h, p.own[h] );
    }
    return p;
}

// With variance v per weight the halves differ by v (1/e + 1/o), the whole has
// v / (e + o): what the square of the difference is multiplied by. 0 where one
// of them is empty.
static inline double rf_film_half_share( const RfFilm* film )
{
    double e = film->weight[0], o = film->weight[1];
    return e > 0.0 && o > 0.0 ? e * o / ( ( e + o ) * ( e + o ) ) : 0.0;
}

// How the sums A and B of a pixel become its value (RfNormalize). Renders cross-fit; the ratio is also that of AOVs, and of the
// estimator of gradients; what is not divided is for comparison. This is done once for a picture and for each estimate of its
// error, not for samples.

// cᵒ_h = Aᵒ_h / Bᵒ_h; 0 where there is none.
static inline double rf_film_own_quotient( const RfFilmPixel* p, int h, int c )
{
    return p->own[h][3] > 0.0 ? p->own[h][c] / p->own[h][3] : 0.0;
}

// c_h = A_h / B_h, without the own-frame light of extra samples; 0 where no sample landed.
static inline double rf_film_quotient( const RfFilmPixel* p, int h, int c )
{
    double a = p->half[h][c] - p->extra[h] * rf_film_own_quotient( p, h, c ), b = p->half[h][3];
    return b > 0.0 || RF_FAULT( empty_half ) ? a / b : 0.0;
}

// A half of (E2) and (E16) in sums, n the weight of its passes: A_e + c_o (n_e − B_e). Where B is exactly n, as without reuse, this
// is A, bit for bit.
static inline double rf_film_crossfit_half( const RfFilmPixel* p, int h, int c )
{
    const double *sums = p->half[h], *own = p->own[h];
    return sums[c] + rf_film_quotient( p, 1 - h, c ) * ( p->weight[h] - sums[3] ) +
           ( own[c] + rf_film_own_quotient( p, 1 - h, c ) * ( p->weight[h] - p->extra[h] - own[3] ) );
}

// (A − e cᵒ) / B + cᵒ, with the weight e of extra samples.
static inline double rf_film_ratio( const RfFilmPixel* p, int c )
{
    double a = p->half[0][c] + p->half[1][c], b = p->half[0][3] + p->half[1][3], own_b = p->own[0][3] + p->own[1][3];
    double own = own_b > 0.0 ? ( p->own[0][c] + p->own[1][c] ) / own_b : 0.0;
    return b > 0.0 ? ( a - ( p->extra[0] + p->extra[1] ) * own ) / b + own : 0.0;
}

static inline double rf_film_value( const RfFilmPixel* p, RfNormalize normalize, int c )
{
    double n = p->weight[0] + p->weight[1];
    switch ( normalize )
    {
        case RF_NORMALIZE_CROSSFIT: return ( rf_film_crossfit_half( p, 0, c ) + rf_film_crossfit_half( p, 1, c ) ) / n;
        case RF_NORMALIZE_RATIO: return rf_film_ratio( p, c );
        case RF_NORMALIZE_NONE: return ( p->half[0][c] + p->half[1][c] + ( p->own[0][c] + p->own[1][c] ) ) / n;
    }
    return 0.0;
}

static inline double rf_film_half_value( const RfFilmPixel* p, RfNormalize normalize, int h, int c )
{
    switch ( normalize )
    {
        case RF_NORMALIZE_CROSSFIT: return rf_film_crossfit_half( p, h, c ) / p->weight[h];
        case RF_NORMALIZE_RATIO: return rf_film_quotient( p, h, c ) + rf_film_own_quotient( p, h, c );
        case RF_NORMALIZE_NONE: return ( p->half[h][c] + p->own[h][c] ) / p->weight[h];
    }
    return 0.0;
}

#endif
