// What `flicker` says: a table, a line in words, JSON.
#ifndef REFRAME_CLI_FLICKER_REPORT_H
#define REFRAME_CLI_FLICKER_REPORT_H

#include "measure/error.h"
#include "measure/flicker.h"
#include "measure/spectrum.h"

#include <jansson.h>

typedef enum RfErrorSource
{
    RF_ERROR_UNKNOWN,
    RF_ERROR_FROM_REFERENCE,
    RF_ERROR_FROM_VARIANCE,
} RfErrorSource;

typedef struct RfFlickerReport
{
    bool compensated, masked; // along the motion, by depth
    bool has_seams;
    bool has_spectrum;
    RfErrorSource source;     // of the errors' mean squares
    RfFlickerSums all, inside, border;
    RfSpectrumSums spectrum;
    int window;               // frames of each window of the spectrum
    RfErrorMetrics errors;    // of all frames; without a reference only the counts mean something
    json_t* pairs;            // an array
} RfFlickerReport;

void rf_print_flicker_head( void );

// The pair of `frame` and the one before.
void rf_print_flicker_pair( int frame, bool border, const RfFlickerSums* sums );

// What comes after the pairs.
void rf_print_flicker_end( const RfFlickerReport* report );

json_t* rf_flicker_pair_json( int frame, bool border, const RfFlickerSums* sums );

// Takes `pairs` over.
json_t* rf_flicker_json( RfFlickerReport* report );

#endif
