// Rows of the tables of a page: [group, label, value].
#ifndef REFRAME_CLI_REPORT_REPORT_ROWS_H
#define REFRAME_CLI_REPORT_REPORT_ROWS_H

#include <jansson.h>

#define RF_FACT_SIZE 240 // characters of a value; the rest is cut

// Appends a row.
void rf_add_fact( json_t* facts, const char* group, const char* label, const char* value );

// Appends a row with a number, by a format of printf; none for NaN and infinity.
void rf_add_fact_number( json_t* facts, const char* group, const char* label, const char* format, double value );

#endif
