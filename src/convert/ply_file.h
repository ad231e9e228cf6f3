// Internal to the PLY reader: the header, and single values of the body.
#ifndef REFRAME_CONVERT_PLY_FILE_H
#define REFRAME_CONVERT_PLY_FILE_H

#include "reframe/error.h"

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
    size_t at;     // offset of the next byte
    uint64_t line; // its line number, in the header and in ASCII bodies
    RfPlyFormat format;
    int element_count;
    RfPlyElement elements[RF_PLY_MAX_ELEMENTS];
    RfError* error;
} RfPlyFile;

// Reads the header and leaves `at` at the first byte of the body.
RfResult rf_ply_read_header( RfPlyFile* file );

// Reads one value; in ASCII bodies the next word.
RfResult rf_ply_read_value( RfPlyFile* file, RfPlyType type, double* value );

// Reads the length of a list and checks it against the bytes left in the file.
RfResult rf_ply_read_count( RfPlyFile* file, const RfPlyProperty* property, uint32_t* count );

// Fails if too few bytes are left for all items of an element, taking lists as empty.
RfResult rf_ply_check_element( const RfPlyFile* file, const RfPlyElement* element );

// Skips one property.
RfResult rf_ply_skip( RfPlyFile* file, const RfPlyProperty* property );

// Fails if anything but ASCII whitespace follows the last element.
RfResult rf_ply_check_end( RfPlyFile* file );

// Fails with RF_ERROR_FORMAT; prefixes the message with the file and the line or byte.
RfResult rf_ply_fail( const RfPlyFile* file, const char* format, ... ) __attribute__( ( format( printf, 2, 3 ) ) );

#endif
