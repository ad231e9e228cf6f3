// What FBX files say that assimp does not pass on, or wrongly: orthographic cameras, weights of shapes, inverse bind matrices,
// corners of far meshes, whether curves are straight. Names become unique, since assimp finds nodes by them.
#include "import/assimp_import.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

// A file is a list of objects with numbers, and of connections between them.

enum
{
    FBX_MODEL,
    FBX_SHAPE,
    FBX_CAMERA,
    FBX_CLUSTER, // what a bone moves
    FBX_SKIN,    // clusters of a geometry
    FBX_GEOMETRY,
    FBX_OTHER
};

typedef struct FbxObject
{
    long long id;
    char* name; // in the text of the source, not terminated
    size_t length;
    int kind;
    double weight;               // of a shape
    double orthographic, height; // of a camera
    double hidden;               // of a model: 1 − its visibility
    size_t matrix;               // of a cluster: where its transformation is in the text; 0: nowhere
    size_t bone, of;             // of a cluster: its bone; of clusters, skins and geometries: what has them; SIZE_MAX: none
} FbxObject;

typedef struct FbxFile
{
    RfSource* source;
    FbxObject* objects;
    size_t count, room;
    size_t* by_id; // the objects
    bool wide;     // records of 64 bits
    bool binary;
    int bent; // curves of animations whose keys are not joined by straight lines
    int dual; // skins that are bent by dual quaternions
} FbxFile;

static FbxObject* add_object( FbxFile* file, long long id, const char* kind, size_t kind_length, char* name, size_t length )
{
    static const char* const kinds[] = { [FBX_MODEL] = "Model",   [FBX_SHAPE] = "BlendShapeChannel",
                                         [FBX_CAMERA] = "Camera", [FBX_CLUSTER] = "Cluster",
                                         [FBX_SKIN] = "Skin",     [FBX_GEOMETRY] = "Mesh" };
    int found = FBX_OTHER;
    for ( int i = 0; i < FBX_OTHER; ++i )
        found = strlen( kinds[i] ) == kind_length && memcmp( kinds[i], kind, kind_length ) == 0 ? i : found;
    if ( found == FBX_OTHER )
        return NULL;
    if ( file->count == file->room )
    {
        size_t room = file->room > 0 ? 2 * file->room : 256;
        FbxObject* more = realloc( file->objects, room * sizeof *more );
        file->source->failed |= more == NULL;
        if ( more == NULL )
            return NULL;
        file->objects = more;
        file->room = room;
    }
    FbxObject* object = file->objects + file->count++;
    *object = ( FbxObject ){ .id = id, .name = name, .length = length, .kind = found, .bone = SIZE_MAX, .of = SIZE_MAX };
    return object;
}

static void set_property( FbxObject* object, const char* name, size_t length, double value )
{
    const struct
    {
        const char* name;
        double* value;
    } all[] = { { "DeformPercent", &object->weight },
                { "CameraProjectionType", &object->orthographic },
                { "OrthoZoom", &object->height } };
    for ( size_t i = 0; i < sizeof all / sizeof all[0]; ++i )
    {
        if ( strlen( all[i].name ) == length && memcmp( all[i].name, name, length ) == 0 )
            *all[i].value = value;
    }
    if ( object->kind == FBX_MODEL && length == 10 && memcmp( name, "Visibility", 10 ) == 0 )
        object->hidden = 1.0 - value;
}

// The object with a number, or NULL.
static FbxObject* find_object( const FbxFile* file, long long id )
{
    size_t low = 0, high = file->by_id != NULL ? file->count : 0;
    while ( low < high )
    {
        size_t middle = low + ( high - low ) / 2;
        FbxObject* object = file->objects + file->by_id[middle];
        if ( object->id == id )
            return object;
        if ( object->id < id )
            low = middle + 1;
        else
            high = middle;
    }
    return NULL;
}

static void connect( FbxFile* file, long long id, long long of )
{
    FbxObject *from = find_object( file, id ), *to = find_object( file, of );
    if ( from == NULL || to == NULL )
        return;
    size_t number = (size_t)( to - file->objects );
    if ( from->kind == FBX_MODEL && to->kind == FBX_CLUSTER )
        to->bone = (size_t)( from - file->objects );
    else if ( ( from->kind == FBX_CLUSTER && to->kind == FBX_SKIN ) || ( from->kind == FBX_SKIN && to->kind == FBX_GEOMETRY ) ||
              ( from->kind == FBX_GEOMETRY && to->kind == FBX_MODEL ) )
        from->of = number;
    RfFact* fact = from->kind == FBX_CAMERA && from->orthographic == 1.0 && to->kind == FBX_MODEL
                       ? rf_add_fact( file->source, RF_FACT_CAMERA, to->name, to->length )
                       : NULL;
    if ( fact == NULL )
        return;
    fact->values[RF_CAMERA_ORTHOGRAPHIC] = 1.0;
    fact->values[RF_CAMERA_XMAG] = 0.5 * from->height;
}

static int compare_objects( const void* left, const void* right )
{
    const FbxObject *a = (const FbxObject*)left, *b = (const FbxObject*)right;
    if ( a->kind != b->kind )
        return a->kind < b->kind ? -1 : 1;
    size_t least = a->length < b->length ? a->length : b->length;
    int order = memcmp( a->name, b->name, least );
    if ( order == 0 && a->length != b->length )
        order = a->length < b->length ? -1 : 1;
    return order != 0 ? order : ( a->name > b->name ) - ( a->name < b->name );
}

// Overwrites the end of a name, whose length must stay, by a number.
static void number_name( char* name, size_t length, unsigned number )
{
    static const char digits[] = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ+-";
    size_t end = length < 5 ? length : 5;
    for ( size_t i = 0; i < end; ++i, number /= 64 )
        name[length - 1 - i] = i == 4 ? '~' : digits[number % 64];
}

typedef struct Number
{
    long long id;
    size_t object;
} Number;

static int compare_numbers( const void* left, const void* right )
{
    const Number *a = left, *b = right;
    return ( a->id > b->id ) - ( a->id < b->id );
}

static void sort_by_id( FbxFile* file )
{
    Number* all = malloc( ( file->count + 1 ) * sizeof *all );
    file->by_id = malloc( ( file->count + 1 ) * sizeof *file->by_id );
    file->source->failed |= all == NULL || file->by_id == NULL;
    for ( size_t i = 0; all != NULL && i < file->count; ++i )
        all[i] = ( Number ){ file->objects[i].id, i };
    if ( all != NULL && file->by_id != NULL )
        qsort( all, file->count, sizeof *all, compare_numbers );
    for ( size_t i = 0; all != NULL && file->by_id != NULL && i < file->count; ++i )
        file->by_id[i] = all[i].object;
    if ( all == NULL )
    {
        free( file->by_id );
        file->by_id = NULL;
    }
    free( all );
}

// Of models and of shapes with one name, all but the first get another, which is noted.
static void make_unique( FbxFile* file )
{
    if ( file->count > 0 )
        qsort( file->objects, file->count, sizeof *file->objects, compare_objects );
    unsigned number = 0;
    char last[256] = "";
    size_t last_length = 0;
    for ( size_t i = 0; i < file->count; ++i )
    {
        FbxObject* o = file->objects + i;
        bool again = i > 0 && o[-1].kind == o->kind && o->length == last_length && o->length > 0 && o->length < sizeof last &&
                     memcmp( o->name, last, o->length ) == 0;
        last_length = o->length;
        memcpy( last, o->name, o->length < sizeof last ? o->length : 0 );
        if ( !again || o->kind > FBX_SHAPE )
            continue;
        number_name( o->name, o->length, ++number );
        RfFact* fact = rf_add_fact( file->source, RF_FACT_NAME, o->name, o->length );
        if ( fact != NULL )
            fact->text = strndup( last, last_length );
    }
    for ( size_t i = 0; i < file->count; ++i )
    {
        const FbxObject* o = file->objects + i;
        if ( o->kind == FBX_MODEL && o->hidden >= 1.0 )
            rf_add_fact( file->source, RF_FACT_HIDDEN, o->name, o->length );
        RfFact* fact = o->kind == FBX_SHAPE ? rf_add_fact( file->source, RF_FACT_WEIGHT, o->name, o->length ) : NULL;
        if ( fact != NULL )
            fact->values[0] = 0.01 * o->weight;
    }
    sort_by_id( file );
}

// A binary FBX is a tree of records: where they end, how many values they have, their name; values; records in them.
typedef struct FbxRecord
{
    size_t name, name_length, values, value_count, inner, end; // offsets
} FbxRecord;

static unsigned long long number_at( const FbxFile* file, size_t at, size_t width )
{
    unsigned long long value = 0;
    for ( size_t i = width; i > 0 && at + width <= file->source->size; --i )
        value = value << 8 | (unsigned char)file->source->text[at + i - 1];
    return value;
}

// False at the end of a list, and where the file is broken.
static bool read_record( const FbxFile* file, size_t at, size_t limit, FbxRecord* record )
{
    size_t width = file->wide ? 8 : 4;
    if ( at + 3 * width + 1 > limit )
        return false;
    unsigned long long end = number_at( file, at, width ), size = number_at( file, at + 2 * width, width );
    record->value_count = number_at( file, at + width, width );
    record->name_length = (unsigned char)file->source->text[at + 3 * width];
    record->name = at + 3 * width + 1;
    record->values = record->name + record->name_length;
    if ( end <= at || end > limit || record->values > end || size > end - record->values )
        return false;
    record->inner = record->values + size;
    record->end = end;
    return true;
}

// One value: a number, or a text. Returns where the next begins, or 0.
static size_t read_value( const FbxFile* file, size_t at, size_t limit, double* number, size_t* text, size_t* length )
{
    if ( at >= limit )
        return 0;
    char type = file->source->text[at++];
    *text = *length = 0;
    *number = 0.0;
    size_t width = type == 'C' || type == 'B'   ? 1
                   : type == 'Y'                ? 2
                   : type == 'I' || type == 'F' ? 4
                   : type == 'D' || type == 'L' ? 8
                                                : 0;
    if ( width > 0 )
    {
        if ( at + width > limit )
            return 0;
        unsigned long long bits = number_at( file, at, width );
        float single;
        unsigned low = (unsigned)bits;
        memcpy( &single, &low, sizeof single );
        if ( type == 'D' )
            memcpy( number, &bits, sizeof bits );
        else
            *number = type == 'F' ? (double)single : type == 'I' ? (double)(int)low : (double)(long long)bits;
        *length = (size_t)bits; // numbers of objects, which doubles do not hold
        return at + width;
    }
    size_t size = number_at( file, at, 4 );
    if ( ( type != 'S' && type != 'R' ) || at + 4 > limit || size > limit - at - 4 )
        return 0; // arrays end the list: nothing that is looked for comes after one
    *text = at + 4;
    *length = size;
    return at + 4 + size;
}

static bool is_named( const FbxFile* file, const FbxRecord* record, const char* name )
{
    return strlen( name ) == record->name_length && memcmp( file->source->text + record->name, name, record->name_length ) == 0;
}

static void note_skinning( FbxFile* file, const char* type, size_t length )
{
    file->dual +=
        ( length == 14 && memcmp( type, "DualQuaternion", 14 ) == 0 ) || ( length == 5 && memcmp( type, "Blend", 5 ) == 0 );
}

// DeformPercent of a shape; of cameras and models the lists "P" with a name and, as their fifth value, a number.
static void read_properties( FbxFile* file, const FbxRecord* parent, FbxObject* object, int depth )
{
    FbxRecord r;
    for ( size_t at = parent->inner; read_record( file, at, parent->end, &r ); at = r.end )
    {
        double number;
        size_t text, length, name, name_length, next = r.values;
        if ( is_named( file, &r, "Properties70" ) && depth < 2 )
            read_properties( file, &r, object, depth + 1 );
        next = read_value( file, next, r.inner, &number, &name, &name_length );
        if ( is_named( file, &r, "Transform" ) && object->kind == FBX_CLUSTER )
            object->matrix = r.values;
        if ( is_named( file, &r, "SkinningType" ) && next > 0 && name != 0 )
            note_skinning( file, file->source->text + name, name_length );
        if ( is_named( file, &r, "DeformPercent" ) && next > 0 && name == 0 )
            set_property( object, "DeformPercent", 13, number );
        if ( !is_named( file, &r, "P" ) || next == 0 || name == 0 )
            continue;
        for ( int i = 0; i < 4 && next > 0; ++i )
            next = read_value( file, next, r.inner, &number, &text, &length );
        if ( next > 0 && text == 0 )
            set_property( object, file->source->text + name, name_length, number );
    }
}

// Reads an array of `count` numbers of `size` bytes, of which a broken file may have fewer; NULL: it is not there.
static char* read_array( const FbxFile* file, size_t at, char type, size_t size, size_t* count )
{
    size_t length = at + 13 <= file->source->size ? number_at( file, at + 9, 4 ) : 0;
    if ( length == 0 || file->source->text[at] != type || length > file->source->size - at - 13 )
        return NULL;
    bool packed = number_at( file, at + 5, 4 ) == 1;
    *count = number_at( file, at + 1, 4 );
    if ( *count > ( packed ? 1024 * length : length / size ) )
        return NULL;
    const char* bytes = file->source->text + at + 13;
    char* out = malloc( *count * size + 1 );
    uLongf room = *count * size;
    if ( out != NULL && !packed )
        memcpy( out, bytes, *count * size );
    else if ( out != NULL && ( uncompress( (Bytef*)out, &room, (const Bytef*)bytes, length ) != Z_OK || room != *count * size ) )
    {
        free( out );
        out = NULL;
    }
    return out;
}

// Flags of keys: 2 stepped, 4 linear, 8 cubic.
static bool is_bent( long long flags ) { return ( flags & 14 ) != 4 && ( flags & 14 ) != 0; }

static void note_curve( FbxFile* file, const FbxRecord* curve )
{
    FbxRecord r;
    for ( size_t at = curve->inner; read_record( file, at, curve->end, &r ); at = r.end )
    {
        size_t count = 0;
        char* flags = is_named( file, &r, "KeyAttrFlags" ) ? read_array( file, r.values, 'i', 4, &count ) : NULL;
        bool bent = false;
        for ( size_t i = 0; flags != NULL && i < count; ++i )
        {
            int value;
            memcpy( &value, flags + 4 * i, sizeof value );
            bent = bent || is_bent( value );
        }
        file->bent += bent;
        free( flags );
    }
}

// The corners of a mesh that is far from its origin, in the order in which assimp has them.
static void note_far( FbxFile* file, const FbxRecord* geometry )
{
    FbxRecord r;
    size_t counts[2] = { 0 };
    char* arrays[2] = { NULL };
    for ( size_t at = geometry->inner; read_record( file, at, geometry->end, &r ); at = r.end )
    {
        if ( is_named( file, &r, "Vertices" ) && arrays[0] == NULL )
            arrays[0] = read_array( file, r.values, 'd', 8, counts );
        if ( is_named( file, &r, "PolygonVertexIndex" ) && arrays[1] == NULL )
            arrays[1] = read_array( file, r.values, 'i', 4, counts + 1 );
    }
    double low[3] = { INFINITY, INFINITY, INFINITY }, high[3] = { -INFINITY, -INFINITY, -INFINITY }, origin[3];
    for ( size_t i = 0; arrays[0] != NULL && i < counts[0]; ++i )
    {
        double value;
        memcpy( &value, arrays[0] + 8 * i, sizeof value );
        low[i % 3] = fmin( low[i % 3], value );
        high[i % 3] = fmax( high[i % 3], value );
    }
    bool far = arrays[0] != NULL && arrays[1] != NULL && counts[0] >= 3 && rf_is_far( low, high, origin );
    float* corners = far ? malloc( ( counts[1] + 1 ) * 3 * sizeof *corners ) : NULL;
    for ( size_t i = 0; corners != NULL && i < 3 * counts[1]; ++i )
    {
        int index;
        double value;
        memcpy( &index, arrays[1] + 4 * ( i / 3 ), sizeof index );
        size_t vertex = (size_t)( index < 0 ? -1 - index : index );
        if ( 3 * vertex + 2 >= counts[0] )
        {
            free( corners );
            corners = NULL;
            break;
        }
        memcpy( &value, arrays[0] + 8 * ( 3 * vertex + i % 3 ), sizeof value );
        corners[i] = (float)( value - origin[i % 3] );
    }
    RfFact* fact = corners != NULL ? rf_add_fact( file->source, RF_FACT_FAR, "", 0 ) : NULL;
    if ( fact != NULL )
    {
        memcpy( fact->values, origin, sizeof origin );
        fact->values[3] = (double)counts[1];
        fact->text = (char*)corners;
    }
    else
        free( corners );
    free( arrays[0] );
    free( arrays[1] );
}

static void read_objects( FbxFile* file, const FbxRecord* parent )
{
    FbxRecord r;
    for ( size_t at = parent->inner; read_record( file, at, parent->end, &r ); at = r.end )
    {
        double number;
        size_t text[3], length[3], next = r.values;
        for ( int i = 0; i < 3 && next > 0; ++i )
            next = read_value( file, next, r.inner, &number, text + i, length + i );
        if ( next == 0 || text[0] != 0 || text[1] == 0 || text[2] == 0 )
            continue;
        char *all = file->source->text, *name = all + text[1];
        const char* end = memchr( name, 0, length[1] ); // the name, 0, 1, its class
        size_t name_length = end != NULL ? (size_t)( end - name ) : length[1];
        if ( is_named( file, &r, "AnimationCurve" ) )
            note_curve( file, &r );
        bool is_model = is_named( file, &r, "Model" );
        FbxObject* object = add_object( file, (long long)length[0], is_model ? "Model" : all + text[2], is_model ? 5 : length[2],
                                        name, name_length );
        if ( object != NULL && object->kind == FBX_GEOMETRY )
            note_far( file, &r );
        if ( object != NULL && object->kind != FBX_GEOMETRY )
            read_properties( file, &r, object, 0 );
    }
}

static void read_binary( FbxFile* file )
{
    file->binary = true;
    file->wide = number_at( file, 23, 4 ) >= 7500;
    FbxRecord r, c;
    for ( int pass = 0; pass < 2; ++pass )
    {
        for ( size_t at = 27; read_record( file, at, file->source->size, &r ); at = r.end )
        {
            if ( pass == 0 && is_named( file, &r, "Objects" ) )
                read_objects( file, &r );
            for ( size_t in = r.inner; pass == 1 && is_named( file, &r, "Connections" ) && read_record( file, in, r.end, &c );
                  in = c.end )
            {
                double number;
                size_t text, ids[2], kind, next = read_value( file, c.values, c.inner, &number, &text, &kind );
                for ( int i = 0; i < 2 && next > 0; ++i )
                    next = read_value( file, next, c.inner, &number, &text, ids + i );
                if ( next > 0 )
                    connect( file, (long long)ids[0], (long long)ids[1] );
            }
        }
        if ( pass == 0 )
            make_unique( file );
    }
}

// The text between the next two quotation marks; returns where it ends.
static char* read_quoted( char* at, const char* end, char** text, size_t* length )
{
    char* open = memchr( at, '"', (size_t)( end - at ) );
    char* close = open != NULL ? memchr( open + 1, '"', (size_t)( end - open - 1 ) ) : NULL;
    *text = close != NULL ? open + 1 : at;
    *length = close != NULL ? (size_t)( close - open - 1 ) : 0;
    return close != NULL ? close + 1 : NULL;
}

// A line of a text FBX: `Model: 12, "Model::name", "Mesh" {`, `DeformPercent: 50`, `P: "OrthoZoom", "double", "Number", "",1`, or
// `C: "OO",1,2`. Returns the object that the following lines are of.
static FbxObject* read_line( FbxFile* file, char* line, char* end, FbxObject* object, int pass )
{
    char *text, *name, *kind;
    size_t length, name_length, kind_length;
    char* value = memchr( line, ':', (size_t)( end - line ) );
    if ( value == NULL )
        return object;
    if ( pass == 1 && strncmp( line, "C:", 2 ) == 0 )
    {
        char* at = read_quoted( value, end, &text, &length );
        long long from, to;
        if ( at != NULL && sscanf( at, " , %lld , %lld", &from, &to ) == 2 )
            connect( file, from, to );
    }
    if ( pass == 1 )
        return NULL;
    if ( strncmp( line, "Model:", 6 ) == 0 || strncmp( line, "Deformer:", 9 ) == 0 ||
         strncmp( line, "NodeAttribute:", 14 ) == 0 || strncmp( line, "Geometry:", 9 ) == 0 )
    {
        char* at = read_quoted( value, end, &name, &name_length );
        at = at != NULL ? read_quoted( at, end, &kind, &kind_length ) : NULL;
        if ( at == NULL )
            return NULL;
        size_t skip = 0; // of "Model::"
        for ( size_t i = 0; i + 1 < name_length && skip == 0; ++i )
            skip = name[i] == ':' && name[i + 1] == ':' ? i + 2 : 0;
        bool is_model = line[0] == 'M';
        return add_object( file, strtoll( value + 1, NULL, 10 ), is_model ? "Model" : kind, is_model ? 5 : kind_length,
                           name + skip, name_length - skip );
    }
    const char* flags = strncmp( line, "KeyAttrFlags:", 13 ) == 0 ? strstr( line, "a:" ) : NULL;
    for ( bool more = flags != NULL; more; more = *flags == ',' )
    {
        char* after;
        bool bent = is_bent( strtoll( flags + ( *flags == ',' ? 1 : 2 ), &after, 10 ) );
        flags = bent ? "" : after;
        file->bent += bent;
    }
    if ( object != NULL && object->kind == FBX_CLUSTER && strncmp( line, "Transform:", 10 ) == 0 )
        object->matrix = (size_t)( line - file->source->text );
    if ( object != NULL && strncmp( line, "DeformPercent:", 14 ) == 0 )
        set_property( object, "DeformPercent", 13, strtod( value + 1, NULL ) );
    if ( object != NULL && strncmp( line, "SkinningType:", 13 ) == 0 && read_quoted( value, end, &text, &length ) != NULL )
        note_skinning( file, text, length );
    if ( object != NULL && ( object->kind == FBX_CAMERA || object->kind == FBX_MODEL ) && strncmp( line, "P:", 2 ) == 0 )
    {
        char* at = read_quoted( value, end, &name, &name_length );
        for ( int i = 0; i < 3 && at != NULL; ++i )
            at = read_quoted( at, end, &text, &length );
        if ( at != NULL && *at == ',' )
            set_property( object, name, name_length, strtod( at + 1, NULL ) );
    }
    return object;
}

static void read_text( FbxFile* file )
{
    for ( int pass = 0; pass < 2; ++pass )
    {
        FbxObject* object = NULL;
        for ( char* line = file->source->text; *line != 0; )
        {
            char* end = line + strcspn( line, "\n" );
            object =
                read_line( file, line + strspn( line, " \t" ) < end ? line + strspn( line, " \t" ) : line, end, object, pass );
            line = *end != 0 ? end + 1 : end;
        }
        if ( pass == 0 )
            make_unique( file );
    }
}

// Reads 16 numbers: an array of doubles, or a text "*16 { a: 1,0,…"; false where they are not there.
static bool read_matrix( const FbxFile* file, size_t at, double out[16] )
{
    if ( file->binary )
    {
        size_t count;
        char* bytes = read_array( file, at, 'd', 8, &count );
        bool good = bytes != NULL && count == 16;
        if ( good )
            memcpy( out, bytes, 16 * sizeof *out );
        free( bytes );
        return good;
    }
    const char* next = strstr( file->source->text + at, "a:" );
    char* end;
    for ( int i = 0; next != NULL && i < 16; ++i )
    {
        next += i == 0 ? 2 : *next == ',';
        out[i] = strtod( next, &end );
        next = end != next ? end : NULL;
    }
    return next != NULL;
}

// The inverse bind matrices of bones, under the names of the node of the mesh and of the bone: what assimp 5.4 gives is relative
// to another node.
static void note_binds( FbxFile* file )
{
    for ( size_t i = 0; i < file->count; ++i )
    {
        const FbxObject *all = file->objects, *cluster = all + i;
        double matrix[16];
        size_t skin = cluster->kind == FBX_CLUSTER ? cluster->of : SIZE_MAX;
        size_t geometry = skin != SIZE_MAX ? all[skin].of : SIZE_MAX, model = geometry != SIZE_MAX ? all[geometry].of : SIZE_MAX;
        char name[1024];
        if ( model == SIZE_MAX || cluster->bone == SIZE_MAX || cluster->matrix == 0 ||
             !read_matrix( file, cluster->matrix, matrix ) )
            continue;
        const FbxObject *bone = all + cluster->bone, *node = all + model;
        int length = snprintf( name, sizeof name, "%.*s\n%.*s", (int)node->length, node->name, (int)bone->length, bone->name );
        RfFact* fact = (size_t)length < sizeof name ? rf_add_fact( file->source, RF_FACT_BIND, name, (size_t)length ) : NULL;
        if ( fact != NULL )
            memcpy( fact->values, matrix, sizeof matrix );
    }
}

void rf_note_fbx( RfSource* source )
{
    FbxFile file = { .source = source };
    if ( source->size > 27 && memcmp( source->text, "Kaydara FBX Binary", 18 ) == 0 )
        read_binary( &file );
    else
        read_text( &file );
    note_binds( &file );
    if ( file.bent > 0 )
        rf_warn( source->log, "%d curves of animations are cubic or stepped: they go straight between their keys", file.bent );
    if ( file.dual > 0 )
        rf_warn( source->log, "%d skins are for dual quaternions: they are bent linearly, thinner at joints that twist",
                 file.dual );
    free( file.objects );
    free( file.by_id );
}
