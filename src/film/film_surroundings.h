// A film in coarse cells: what is known of the surroundings of a pixel beyond its direct
// neighbours. For src/film only.
#ifndef REFRAME_FILM_FILM_SURROUNDINGS_H
#define REFRAME_FILM_FILM_SURROUNDINGS_H

#include "film/film.h"

#define RF_CELLS 32 // across and down, at most

// Sums over the pixels of a cell, each the mean of its channels.
typedef struct RfFilmCell
{
    double half[2];
    double squared; // of the difference of the halves
    int pixels;
} RfFilmCell;

typedef struct RfSurroundings
{
    int side; // of a cell, pixels
    int columns, rows;
    RfFilmCell cells[RF_CELLS][RF_CELLS];
    RfFilmCell all;
    double share;       // rf_film_half_share
    double correlation; // of errors in neighbouring pixels: variance of a sum over that of independent ones, at least 1
} RfSurroundings;

// The wide surroundings of a pixel.
typedef struct RfAround
{
    double mean;     // in one half, drawn towards the picture's where it is noisy
    double variance; // of a pixel of the picture
} RfAround;

// Sums a film up.
void rf_survey_film( const RfFilm* film, RfFilmCombine combine, RfSurroundings* around );

// The 3×3 cells around pixel (x, y) without its own values `pixel`, in one half.
RfAround rf_look_around( const RfSurroundings* around, int x, int y, int half, const double pixel[2] );

// The part of a deviation from `mean` that is signal where noise has this variance, if the signal
// deviates by about as much as the mean itself. 0 to 1.
static inline double rf_signal_share( double mean, double variance )
{
    double signal = mean * mean;
    return signal > 0.0 ? signal / ( signal + variance ) : 0.0;
}

#endif
