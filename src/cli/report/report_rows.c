#include "cli/report/report_rows.h"

#include "cli/messages.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

void rf_add_fact( json_t* facts, const char* group, const char* label, const char* value )
{
    char cut[RF_FACT_SIZE + 4];
    snprintf( cut, sizeof cut, "%.*s%s", RF_FACT_SIZE, value, strlen( value ) > RF_FACT_SIZE ? "..." : "" );
    json_t* row = json_array();
    json_array_append_new( row, rf_json_text( group ) );
    json_array_append_new( row, rf_json_text( label ) );
    json_array_append_new( row, rf_json_text( cut ) );
    json_array_append_new( facts, row );
}

void rf_add_fact_number( json_t* facts, const char* group, const char* label, const char* format, double value )
{
    char text[64];
    snprintf( text, sizeof text, format, value );
    if ( isfinite( value ) )
        rf_add_fact( facts, group, label, text );
}
