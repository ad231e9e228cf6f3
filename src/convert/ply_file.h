// Inside of the PLY reader: the header, and values of the body one by one.
#ifndef REFRAME_CONVERT_PLY_FILE_H
#define REFRAME_CONVERT_PLY_FILE_H

#include "reframe/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define RF_PLY_NAME 48
#define RF_PLY_MAX_ELEMENTS 32
#define RF_PLY_MAX_PROPERTIES 64

typedef enum RfPlyFormat
{
    RF_PLY_ASCII,
    RF_PLY_LITTLE_ENDIAN,
    RF_PLY_BIG_ENDIAN,
} RfPlyFormat;

typedef enum RfPlyType
{
    RF_PLY_INT8,
    RF_PLY_UINT8,
    RF_PLY_INT16,
    RF_PLY_UINT16,
    RF_PLY_INT32,
    RF_PLY_UINT32,
    RF_PLY_FLOAT32,
    RF_PLY_FLOAT64,
    RF_PLY_TYPE_COUNT
} RfPlyType;

typedef struct RfPlyProperty
{
    char name[RF_PLY_NAME];
    RfPlyType type;
    bool is_list;
    RfPlyType count_type; // of lists
} RfPlyProperty;

typedef struct RfPlyElement
{
    char name[RF_PLY_NAME];
    uint64_t count;
    int property_count;
    RfPlyProperty properties[RF_PLY_MAX_PROPERTIES];
} RfPlyElement;

typedef struct RfPlyFile
{
    const char* path;
    const uint8_t* bytes;
    size_t size;
    size_t at;     // next byte
    uint64_t line; // of it, in the header and in ascii bodies
    RfPlyFormat format;
    int element_count;
    RfPlyElement elements[RF_PLY_MAX_ELEMENTS];
    RfError* error;
} RfPlyFile;

// Reads the header; `at` is the body's first byte then.
RfResult rf_ply_read_header( RfPlyFile* file );

// One value. In ascii bodies the next word.
RfResult rf_ply_read_value( RfPlyFile* file, RfPlyType type, double* value );

// The length of a list, of which `type` says what follows: as many values can
// still be in the file.
RfResult rf_ply_read_count( RfPlyFile* file, const RfPlyProperty* property, uint32_t* count );

// Are there bytes enough left for all of an element? (For its lists: if empty.)
RfResult rf_ply_check_element( const RfPlyFile* file, const RfPlyElement* element );

// Reads past one property.
RfResult rf_ply_skip( RfPlyFile* file, const RfPlyProperty* property );

// Fails where something follows the last element; blanks may in ascii.
RfResult rf_ply_check_end( RfPlyFile* file );

// One error line: the file, the line or byte, what is wrong, what to do.
RfResult rf_ply_fail( const RfPlyFile* file, const char* format, ... ) __attribute__( ( format( printf, 2, 3 ) ) );

#endif
