#include "film/film_surroundings.h"

#include "film/film_pixel.h"

#include <math.h>
#include <string.h>

#define LEAST_SIDE 8 // pixels

static void add_pixel( RfFilmCell* cell, const double half[2] )
{
    double d = half[0] - half[1];
    cell->half[0] += half[0];
    cell->half[1] += half[1];
    cell->squared += d * d;
    cell->pixels += 1;
}

static void add_cell( RfFilmCell* sum, const RfFilmCell* cell )
{
    sum->half[0] += cell->half[0];
    sum->half[1] += cell->half[1];
    sum->squared += cell->squared;
    sum->pixels += cell->pixels;
}

// Mean of the channels in each half.
static void grey( const RfFilm* film, RfFilmCombine combine, size_t i, double half[2] )
{
    RfFilmPixel p = rf_film_pixel( film, i );
    for ( int h = 0; h < 2; ++h )
    {
        half[h] = 0.0;
        for ( int c = 0; c < 3; ++c )
            half[h] += rf_film_half_value( &p, combine, h, c ) / 3.0;
    }
}

// Errors that are independent add up in their squares, those of a tile in themselves.
static double correlation_of( const RfSurroundings* around )
{
    double of_sums = 0.0;
    for ( int row = 0; row < around->rows; ++row )
    {
        for ( int column = 0; column < around->columns; ++column )
        {
            const RfFilmCell* cell = &around->cells[row][column];
            double d = cell->half[0] - cell->half[1];
            of_sums += d * d;
        }
    }
    return around->all.squared > 0.0 ? fmax( of_sums / around->all.squared, 1.0 ) : 1.0;
}

void rf_survey_film( const RfFilm* film, RfFilmCombine combine, RfSurroundings* around )
{
    int longer = film->width > film->height ? film->width : film->height, side = ( longer + RF_CELLS - 1 ) / RF_CELLS;
    memset( around, 0, sizeof *around );
    around->side = side = side > LEAST_SIDE ? side : LEAST_SIDE;
    around->columns = ( film->width + side - 1 ) / side;
    around->rows = ( film->height + side - 1 ) / side;
    around->share = rf_film_half_share( film );
    for ( int y = 0; y < film->height; ++y )
    {
        for ( int x = 0; x < film->width; ++x )
        {
            double half[2];
            grey( film, combine, (size_t)y * (size_t)film->width + (size_t)x, half );
            add_pixel( &around->cells[y / side][x / side], half );
        }
    }
    for ( int row = 0; row < around->rows; ++row )
    {
        for ( int column = 0; column < around->columns; ++column )
            add_cell( &around->all, &around->cells[row][column] );
    }
    around->correlation = correlation_of( around );
}

RfAround rf_look_around( const RfSurroundings* around, int x, int y, int half, const double pixel[2] )
{
    int column = x / around->side, row = y / around->side;
    int left = column > 0 ? column - 1 : 0, right = column + 1 < around->columns ? column + 1 : column;
    int top = row > 0 ? row - 1 : 0, bottom = row + 1 < around->rows ? row + 1 : row;
    RfFilmCell sum = { .half = { -pixel[0], -pixel[1] },
                       .squared = -( pixel[0] - pixel[1] ) * ( pixel[0] - pixel[1] ),
                       .pixels = -1 };
    for ( int i = top; i <= bottom; ++i )
    {
        for ( int k = left; k <= right; ++k )
            add_cell( &sum, &around->cells[i][k] );
    }
    double whole = fmax( around->all.half[half] / around->all.pixels, 0.0 );
    if ( sum.pixels < 1 )
        return ( RfAround ){ .mean = whole };
    double variance = around->share * fmax( sum.squared, 0.0 ) / sum.pixels;
    double mean = sum.half[half] / sum.pixels;
    return ( RfAround ){
        .mean = whole + rf_signal_share( whole, variance * around->correlation / sum.pixels ) * ( mean - whole ),
        .variance = variance,
    };
}
