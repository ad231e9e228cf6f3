// The pictures of one estimator by seeds, and the statistics of them.
#ifndef REFRAME_TESTS_HARD_PICTURES_H
#define REFRAME_TESTS_HARD_PICTURES_H

#include "hard/hard.h"

#define HARD_MOST_SEEDS 32

// Pictures of the tested frame, one per seed.
typedef struct HardPictures
{
    int width, height, count;
    double* rgb[HARD_MOST_SEEDS];
    double weight[HARD_MOST_SEEDS]; // mean of the pixels' weights, B of (E2)
} HardPictures;

// How pictures differ from what is known.
typedef struct HardDifference
{
    double whole_p, block_p; // that the mean is equal; by Šidák, that those of all parts are
    double weight_p;         // that the mean of the weights is 1
    double bias, interval;   // of the mean, relative, and half of its 95% interval
} HardDifference;

// A black picture.
double* hard_new_picture( const HardPictures* p );

void hard_free_pictures( HardPictures* p );

// Welch's test of the whole and of its parts: blocks, rows and columns.
void hard_compare( const HardPictures* a, const HardPictures* b, HardDifference* out );

// What is known in closed form: one radiance.
void hard_compare_value( const HardPictures* p, const HardScene* h, HardDifference* out );

// The weights that land in a pixel are 1 in the mean (E2): a wrong density shows here first, since pictures are divided by them.
double hard_mean_weight_p( const HardPictures* p );

// Σ variance over the seeds / (mean² + (mean of the picture / 10)²): the relMSE of pictures without bias.
double hard_relmse( const HardPictures* p, const HardPictures* guide );

// Values that are not black.
int hard_count_lit( const HardPictures* p );

#endif
