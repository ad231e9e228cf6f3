// Names of a Cryptomatte's ids: a manifest in the header of the file has them (Friedman and Jones, Cryptomatte Specification 1.2.0).
#ifndef REFRAME_PAGE_MATTE_NAMES_H
#define REFRAME_PAGE_MATTE_NAMES_H

#include "page/pass_groups.h"

#include <stdint.h>

typedef struct RfMatteName
{
    uint32_t id; // the bits of the float that has it
    char* name;
} RfMatteName;

typedef struct RfMatteNames
{
    RfMatteName* names; // by id, ascending
    int count;
} RfMatteNames;

// Reads the names of a pass that is a Cryptomatte; none where the file has no manifest of it. Fails with RF_ERROR_MEMORY and as
// rf_list_exr_strings. Free it in any case.
RfResult rf_read_matte_names( const char* path, const RfFilePass* pass, RfMatteNames* names, RfError* error );
void rf_free_matte_names( RfMatteNames* names );

// The index of an id, or -1.
int rf_find_matte_name( const RfMatteNames* names, uint32_t id );

#endif
