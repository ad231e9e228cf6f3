// What Collada files and material libraries (MTL) say that assimp does not pass on: kinds of cameras, area lights, weights of
// morph targets, where textures lie. Of what it gets wrong in Collada files, the text is changed.
#include "import/assimp_import.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

// Collada: elements are looked for in the text.

// An attribute of the tag at `tag`; empty if it is not there.
static void get_attribute( const char* tag, const char* name, char* out, size_t size )
{
    size_t length = strlen( name );
    const char* end = tag + strcspn( tag, ">" );
    *out = 0;
    for ( const char* at = tag; at < end; ++at )
    {
        if ( !isspace( (unsigned char)*at ) || strncmp( at + 1, name, length ) != 0 || at[1 + length] != '=' )
            continue;
        char quote[2] = { at[2 + length], 0 };
        const char* value = at + 3 + length;
        if ( ( *quote == '"' || *quote == '\'' ) && value < end )
            snprintf( out, size, "%.*s", (int)strcspn( value, quote ), value );
        return;
    }
}

// The number in an element between two places; 0 if it is not there.
static double get_number( const char* from, const char* to, const char* element )
{
    const char* at = strstr( from, element );
    at = at != NULL && at < to ? strchr( at, '>' ) : NULL;
    return at != NULL && at < to ? strtod( at + 1, NULL ) : 0.0;
}

// Adds a fact for every node that has an instance of an element.
static void note_instances( RfSource* source, RfFactKind kind, const char* instance, const char* id, const double* values )
{
    char url[256], name[256];
    const char* node = NULL;
    size_t length = strlen( instance );
    for ( const char* at = strchr( source->text, '<' ); at != NULL; at = strchr( at + 1, '<' ) )
    {
        if ( strncmp( at, "<node", 5 ) == 0 && isspace( (unsigned char)at[5] ) )
            node = at;
        if ( node == NULL || strncmp( at, instance, length ) != 0 )
            continue;
        get_attribute( at, "url", url, sizeof url );
        if ( url[0] != '#' || strcmp( url + 1, id ) != 0 )
            continue;
        get_attribute( node, "id", name, sizeof name );
        if ( *name == 0 )
            get_attribute( node, "sid", name, sizeof name );
        RfFact* fact = *name != 0 ? rf_add_fact( source, kind, name, strlen( name ) ) : NULL;
        if ( fact != NULL )
            memcpy( fact->values, values, sizeof fact->values );
    }
}

static void note_camera( RfSource* source, const char* at, const char* end, const char* id )
{
    double values[RF_FACT_VALUES] = { 0 };
    const char* orthographic = strstr( at, "<orthographic" );
    double meter = 0.0;
    char text[64];
    const char* unit = strstr( source->text, "<unit" );
    if ( unit != NULL )
    {
        get_attribute( unit, "meter", text, sizeof text );
        meter = strtod( text, NULL );
    }
    meter = meter > 0.0 && isfinite( meter ) ? meter : 1.0;
    values[RF_CAMERA_ORTHOGRAPHIC] = orthographic != NULL && orthographic < end;
    values[RF_CAMERA_XMAG] = meter * get_number( at, end, "<xmag" );
    values[RF_CAMERA_YMAG] = meter * get_number( at, end, "<ymag" );
    values[RF_CAMERA_XFOV] = get_number( at, end, "<xfov" );
    values[RF_CAMERA_YFOV] = get_number( at, end, "<yfov" );
    values[RF_CAMERA_ASPECT] = get_number( at, end, "<aspect_ratio" );
    note_instances( source, RF_FACT_CAMERA, "<instance_camera", id, values );
}

// Blender writes area lights as points, and in an <extra> what they are.
static void note_light( RfSource* source, const char* at, const char* end, const char* id )
{
    double width = get_number( at, end, "<area_size " ), height = get_number( at, end, "<area_sizey" );
    bool square = get_number( at, end, "<area_shape" ) == 0.0;
    const double values[RF_FACT_VALUES] = { width, square ? width : height };
    if ( get_number( at, end, "<type " ) == 4.0 && width > 0.0 )
        note_instances( source, RF_FACT_AREA, "<instance_light", id, values );
}

// Changes of the text, in ascending order.
typedef struct Edit
{
    size_t at, length; // what is replaced
    char* text;
    int order; // of what is put in at one place
} Edit;

typedef struct Node
{
    char id[128], sid[128];
    int parent;
} Node;

typedef struct Collada
{
    RfSource* source;
    Edit* edits;
    int edit_count, edit_room;
    Node* nodes;
    int node_count, node_room;
} Collada;

static bool has_room( Collada* c, void** list, int count, int* room, size_t size )
{
    if ( count < *room )
        return true;
    int more = *room > 0 ? 2 * *room : 64;
    void* larger = realloc( *list, (size_t)more * size );
    c->source->failed |= larger == NULL;
    if ( larger == NULL )
        return false;
    *list = larger;
    *room = more;
    return true;
}

static void add_edit( Collada* c, const char* at, size_t length, const char* text )
{
    char* copy = has_room( c, (void**)&c->edits, c->edit_count, &c->edit_room, sizeof *c->edits ) ? strdup( text ) : NULL;
    c->source->failed |= copy == NULL;
    if ( copy != NULL )
    {
        c->edits[c->edit_count] = ( Edit ){ (size_t)( at - c->source->text ), length, copy, c->edit_count };
        c->edit_count += 1;
    }
}

static int compare_edits( const void* a, const void* b )
{
    const Edit *left = a, *right = b;
    if ( left->at != right->at )
        return left->at < right->at ? -1 : 1;
    if ( ( left->length == 0 ) != ( right->length == 0 ) )
        return left->length == 0 ? -1 : 1;
    return left->order - right->order;
}

static void apply_edits( Collada* c )
{
    size_t room = c->source->size + 1, size = 0, from = 0;
    for ( int i = 0; i < c->edit_count; ++i )
        room += strlen( c->edits[i].text );
    char* out = c->edit_count > 0 ? malloc( room ) : NULL;
    c->source->failed |= out == NULL && c->edit_count > 0;
    if ( out == NULL )
        return;
    qsort( c->edits, (size_t)c->edit_count, sizeof *c->edits, compare_edits );
    for ( int i = 0; i < c->edit_count; ++i )
    {
        const Edit* edit = c->edits + i;
        if ( edit->at < from )
            continue; // of one place twice
        memcpy( out + size, c->source->text + from, edit->at - from );
        size += edit->at - from;
        memcpy( out + size, edit->text, strlen( edit->text ) );
        size += strlen( edit->text );
        from = edit->at + edit->length;
    }
    memcpy( out + size, c->source->text + from, c->source->size - from + 1 );
    free( c->source->text );
    c->source->text = out;
    c->source->size = size + c->source->size - from;
}

// The nodes with their parents.
static void read_nodes( Collada* c )
{
    int open = -1;
    for ( const char* at = strchr( c->source->text, '<' ); at != NULL; at = strchr( at + 1, '<' ) )
    {
        if ( strncmp( at, "</node>", 7 ) == 0 && open >= 0 )
            open = c->nodes[open].parent;
        if ( strncmp( at, "<node", 5 ) != 0 || !( isspace( (unsigned char)at[5] ) || at[5] == '>' ) )
            continue;
        if ( !has_room( c, (void**)&c->nodes, c->node_count, &c->node_room, sizeof *c->nodes ) )
            return;
        Node* node = c->nodes + c->node_count;
        node->parent = open;
        get_attribute( at, "id", node->id, sizeof node->id );
        get_attribute( at, "sid", node->sid, sizeof node->sid );
        if ( at[strcspn( at, ">" ) - 1] != '/' )
            open = c->node_count;
        c->node_count += 1;
        char type[16];
        get_attribute( at, "type", type, sizeof type );
        if ( strcmp( type, "JOINT" ) == 0 )
            rf_add_fact( c->source, RF_FACT_JOINT, node->id, strlen( node->id ) );
    }
}

static bool is_below( const Collada* c, int node, const char* root )
{
    for ( ; node >= 0; node = c->nodes[node].parent )
    {
        if ( strcmp( c->nodes[node].id, root ) == 0 )
            return true;
    }
    return false;
}

// The element with an id, or NULL.
static const char* find_element( const Collada* c, const char* element, const char* id )
{
    char own[256];
    size_t length = strlen( element );
    for ( const char* at = strstr( c->source->text, element ); at != NULL; at = strstr( at + 1, element ) )
    {
        if ( !isspace( (unsigned char)at[length] ) )
            continue;
        get_attribute( at, "id", own, sizeof own );
        if ( strcmp( own, id ) == 0 )
            return at;
    }
    return NULL;
}

// Names of joints are those below the skeletons that an instance names: assimp takes the first in the file. They become ids.
static void name_joints( Collada* c, const char* list, const char* instance, const char* instance_end )
{
    const char* end = list + strcspn( list, "<" );
    for ( const char* word = list + strspn( list, " \t\r\n" ); word < end; )
    {
        size_t length = strcspn( word, " \t\r\n<" );
        int found = -1;
        for ( const char* s = instance; found < 0 && ( s = strstr( s, "<skeleton>" ) ) != NULL && s < instance_end; ++s )
        {
            char root[256];
            const char* name = s + 10 + strspn( s + 10, " \t\r\n#" );
            snprintf( root, sizeof root, "%.*s", (int)strcspn( name, " \t\r\n<" ), name );
            for ( int i = 0; found < 0 && i < c->node_count; ++i )
            {
                const Node* node = c->nodes + i;
                if ( strlen( node->sid ) == length && strncmp( node->sid, word, length ) == 0 && node->id[0] != 0 &&
                     is_below( c, i, root ) )
                    found = i;
            }
        }
        if ( found >= 0 && strpbrk( c->nodes[found].id, " \t" ) == NULL )
            add_edit( c, word, length, c->nodes[found].id );
        word += length;
        word += strspn( word, " \t\r\n" );
    }
}

// Makes a list of matrices identities.
static void forget_binds( Collada* c, const char* list )
{
    char count[32];
    get_attribute( list, "count", count, sizeof count );
    const char* values = list + strcspn( list, ">" ) + 1;
    size_t length = strcspn( values, "<" ), matrices = strtoul( count, NULL, 10 ) / 16;
    static const char identity[] = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 ";
    size_t size = sizeof identity - 1;
    char* text = matrices < length ? malloc( matrices * size + 1 ) : NULL;
    if ( text == NULL )
        return;
    for ( size_t i = 0; i < matrices; ++i )
        memcpy( text + i * size, identity, size );
    text[matrices * size] = 0;
    add_edit( c, values, length, text );
    free( text );
}

// The skin of an instance: the names of its joints; and where it is one of morph targets, which assimp does not follow, it becomes
// one of their mesh, whose targets assimp finds.
static void mend_skin( Collada* c, const char* instance )
{
    char id[256], source[256];
    const char* instance_end = strstr( instance, "</instance_controller>" );
    get_attribute( instance, "url", id, sizeof id );
    const char* controller = id[0] == '#' ? find_element( c, "<controller", id + 1 ) : NULL;
    const char* end = controller != NULL ? strstr( controller, "</controller>" ) : NULL;
    const char* skin = end != NULL ? strstr( controller, "<skin" ) : NULL;
    if ( skin == NULL || skin > end || instance_end == NULL )
        return;
    get_attribute( skin, "source", id, sizeof id );
    const char* inner = id[0] == '#' ? find_element( c, "<controller", id + 1 ) : NULL;
    const char* morph = inner != NULL ? strstr( inner, "<morph" ) : NULL;
    const char* old = strchr( skin, '#' );
    if ( morph != NULL && morph < strstr( inner, "</controller>" ) && old != NULL )
    {
        get_attribute( morph, "source", source, sizeof source );
        add_edit( c, old, strlen( id ), source );
    }
    const char* joints = strstr( skin, "<joints>" );
    for ( const char* in = joints; in != NULL && in < end; in = strstr( in + 1, "<input" ) )
    {
        get_attribute( in, "semantic", id, sizeof id );
        get_attribute( in, "source", source, sizeof source );
        bool names = strcmp( id, "JOINT" ) == 0, binds = strcmp( id, "INV_BIND_MATRIX" ) == 0;
        const char* list = ( names || binds ) && source[0] == '#' ? find_element( c, "<source", source + 1 ) : NULL;
        list = list != NULL ? strstr( list, names ? "<Name_array" : "<float_array" ) : NULL;
        if ( list != NULL && list < end && names )
            name_joints( c, list + strcspn( list, ">" ) + 1, instance, instance_end );
        else if ( list != NULL && list < end && c->source->binds_at_rest )
            forget_binds( c, list );
    }
}

// The list of a source between two places, by the meaning of an input: where it begins, or NULL.
static const char* find_list( const Collada* c, const char* from, const char* to, const char* meaning, const char* list )
{
    char id[256];
    for ( const char* in = strstr( from, "<input" ); in != NULL && in < to; in = strstr( in + 1, "<input" ) )
    {
        get_attribute( in, "semantic", id, sizeof id );
        if ( strcmp( id, meaning ) != 0 )
            continue;
        get_attribute( in, "source", id, sizeof id );
        const char* source = id[0] == '#' ? find_element( c, "<source", id + 1 ) : NULL;
        const char* end = source != NULL ? strstr( source, "</source>" ) : NULL;
        const char* found = end != NULL ? strstr( source, list ) : NULL;
        return found != NULL && found < end ? found + strcspn( found, ">" ) + 1 : NULL;
    }
    return NULL;
}

// The sources of weights, which animations move by number: "weights(2)".
static void note_weight_keys( Collada* c, const char* weights, const char* mesh )
{
    size_t length = strlen( weights );
    char id[256];
    for ( const char* at = strstr( c->source->text, "<channel" ); at != NULL; at = strstr( at + 1, "<channel" ) )
    {
        get_attribute( at, "target", id, sizeof id );
        if ( strncmp( id, weights, length ) != 0 || id[length] != '(' )
            continue;
        int slot = (int)strtol( id + length + 1, NULL, 10 );
        get_attribute( at, "source", id, sizeof id );
        const char* sampler = id[0] == '#' ? find_element( c, "<sampler", id + 1 ) : NULL;
        const char* end = sampler != NULL ? strstr( sampler, "</sampler>" ) : NULL;
        const char* times = end != NULL ? find_list( c, sampler, end, "INPUT", "<float_array" ) : NULL;
        const char* values = end != NULL ? find_list( c, sampler, end, "OUTPUT", "<float_array" ) : NULL;
        while ( times != NULL && values != NULL )
        {
            char *next_time, *next_value;
            double time = strtod( times, &next_time ), value = strtod( values, &next_value );
            RfFact* fact =
                next_time != times && next_value != values ? rf_add_fact( c->source, RF_FACT_KEY, mesh, strlen( mesh ) ) : NULL;
            if ( fact == NULL )
                break;
            fact->slot = slot;
            fact->values[0] = time;
            fact->values[1] = value;
            times = next_time;
            values = next_value;
        }
        add_edit( c, at, strcspn( at, ">" ) + 1, "" ); // assimp would write behind its list
    }
}

// The positions of a geometry, from the array to the end of their source; NULL: it has none.
static const char* find_positions( const Collada* c, const char* geometry, const char** vertices, const char** end )
{
    *vertices = geometry != NULL ? strstr( geometry, "<vertices" ) : NULL;
    const char* last = *vertices != NULL ? strstr( *vertices, "</vertices>" ) : NULL;
    char id[256];
    for ( const char* in = *vertices; in != NULL && last != NULL && in < last; in = strstr( in + 1, "<input" ) )
    {
        get_attribute( in, "semantic", id, sizeof id );
        if ( strcmp( id, "POSITION" ) != 0 )
            continue;
        get_attribute( in, "source", id, sizeof id );
        const char* source = id[0] == '#' ? find_element( c, "<source", id + 1 ) : NULL;
        const char* array = source != NULL ? strstr( source, "<float_array" ) : NULL;
        *end = source != NULL ? strstr( source, "</source>" ) : NULL;
        return array != NULL && *end != NULL && array < *end ? array : NULL;
    }
    return NULL;
}

// Replaces all of a word in a text that the caller frees, and frees the old one; NULL: out of memory.
static char* replace_all( char* text, const char* old, const char* with )
{
    size_t count = 0, from = strlen( old ), to = strlen( with );
    for ( const char* at = text; at != NULL && ( at = strstr( at, old ) ) != NULL; at += from )
        ++count;
    char* out = text != NULL ? malloc( strlen( text ) + count * to + 1 ) : NULL;
    char* put = out;
    for ( const char* at = text; out != NULL; )
    {
        const char* next = strstr( at, old );
        size_t length = next != NULL ? (size_t)( next - at ) : strlen( at );
        memcpy( put, at, length );
        put += length;
        if ( next == NULL )
            break;
        memcpy( put, with, to );
        put += to;
        at = next + from;
    }
    if ( out != NULL )
        *put = 0;
    free( text );
    return out;
}

// Adds a geometry with the faces of `mesh` and the positions of `target`, whose own faces may be in another order. Its name is
// that of the target's node.
static void add_target( Collada* c, const char* mesh, const char* target )
{
    char id[256], name[300], text[2048];
    const char *vertices, *base_end, *array_end, *unused;
    const char *base = find_element( c, "<geometry", mesh ), *other = find_element( c, "<geometry", target );
    const char* library_end = base != NULL ? strstr( base, "</library_geometries>" ) : NULL;
    const char* array = find_positions( c, other, &unused, &array_end );
    const char* faces_end = base != NULL ? strstr( base, "</mesh>" ) : NULL;
    if ( library_end == NULL || array == NULL || faces_end == NULL || find_positions( c, base, &vertices, &base_end ) == NULL ||
         vertices > faces_end )
        return;
    get_attribute( vertices, "id", id, sizeof id );
    snprintf( name, sizeof name, RF_TARGET_NODE "%s", target );
    snprintf( text, sizeof text, "<geometry id=\"%s\"><mesh><source id=\"%s-p\">", name, name );
    add_edit( c, library_end, 0, text );
    char* positions = strndup( array, (size_t)( array_end - array ) );
    if ( positions != NULL )
        add_edit( c, library_end, 0, positions );
    free( positions );
    snprintf( text, sizeof text, "</source><vertices id=\"%s-v\"><input semantic=\"POSITION\" source=\"#%s-p\"/></vertices>",
              name, name );
    add_edit( c, library_end, 0, text );
    const char* faces = strstr( vertices, "</vertices>" );
    char *old = malloc( 512 ), *with = malloc( 512 ),
         *all = faces != NULL ? strndup( faces + 11, (size_t)( faces_end - faces - 11 ) ) : NULL;
    if ( old != NULL && with != NULL && all != NULL )
    {
        snprintf( old, 512, "\"#%s\"", id );
        snprintf( with, 512, "\"#%s-v\"", name );
        all = replace_all( all, old, with );
        old[0] = old[strlen( old ) - 1] = '\'';
        all = all != NULL ? replace_all( all, old, with ) : NULL;
    }
    c->source->failed |= old == NULL || with == NULL || all == NULL || positions == NULL;
    if ( all != NULL )
        add_edit( c, library_end, 0, all );
    add_edit( c, library_end, 0, "</mesh></geometry>" );
    free( old );
    free( with );
    free( all );
}

// Notes what a morph controller says, and has its targets as meshes in the scene: assimp refuses files with one.
static void take_morph_controller( Collada* c, const char* controller, const char* morph, const char* end, const char* scene_end )
{
    char mesh[256], method[32], weights[256] = "", text[1024], target[256];
    get_attribute( morph, "source", mesh, sizeof mesh );
    get_attribute( morph, "method", method, sizeof method );
    for ( const char* in = strstr( morph, "<input" ); in != NULL && in < end; in = strstr( in + 1, "<input" ) )
    {
        get_attribute( in, "semantic", text, sizeof text );
        if ( strcmp( text, "MORPH_WEIGHT" ) == 0 )
            get_attribute( in, "source", weights, sizeof weights );
    }
    const char* names = find_list( c, morph, end, "MORPH_TARGET", "_array" );
    const char* values = find_list( c, morph, end, "MORPH_WEIGHT", "<float_array" );
    for ( int slot = 0; mesh[0] == '#' && names != NULL && *( names += strspn( names, " \t\r\n" ) ) != '<'; ++slot )
    {
        size_t length = strcspn( names, " \t\r\n<" );
        char* next = NULL;
        double weight = values != NULL ? strtod( values, &next ) : 0.0;
        snprintf( target, sizeof target, "%.*s", (int)length, names );
        RfFact* fact = rf_add_fact( c->source, RF_FACT_WEIGHT, mesh + 1, strlen( mesh + 1 ) );
        if ( fact == NULL || length == 0 || *names == 0 )
            break;
        fact->slot = slot;
        fact->values[0] = weight;
        fact->values[1] = strcmp( method, "RELATIVE" ) == 0;
        fact->text = strdup( target );
        snprintf( text, sizeof text,
                  "<node id=\"" RF_TARGET_NODE "%s\"><instance_geometry url=\"#" RF_TARGET_NODE "%s\"/></node>", target, target );
        add_edit( c, scene_end, 0, text );
        add_target( c, mesh + 1, target );
        names += length;
        values = next;
    }
    if ( weights[0] == '#' )
        note_weight_keys( c, weights + 1, mesh + 1 );
    add_edit( c, controller, (size_t)( end - controller ), "" );
}

// Instances of a morph controller become those of its mesh.
static void place_mesh( Collada* c, const char* id, const char* mesh )
{
    char url[256];
    for ( const char* at = strstr( c->source->text, "<instance_controller" ); at != NULL;
          at = strstr( at + 1, "<instance_controller" ) )
    {
        get_attribute( at, "url", url, sizeof url );
        const char* name = strchr( at, '#' );
        const char* end = strstr( at, "</instance_controller>" );
        if ( url[0] != '#' || strcmp( url + 1, id ) != 0 || name == NULL )
            continue;
        add_edit( c, at, 20, "<instance_geometry" );
        add_edit( c, name, strlen( url ), mesh );
        if ( at[strcspn( at, ">" ) - 1] != '/' && end != NULL )
            add_edit( c, end, 22, "</instance_geometry>" );
    }
}

static void mend_morphs( Collada* c )
{
    char id[256], mesh[256];
    const char* scene_end = strstr( c->source->text, "</visual_scene>" );
    for ( const char* at = strstr( c->source->text, "<controller" ); at != NULL; at = strstr( at + 1, "<controller" ) )
    {
        const char *end = strstr( at, "</controller>" ), *morph = strstr( at, "<morph" );
        if ( end == NULL || morph == NULL || morph > end || scene_end == NULL )
            continue;
        get_attribute( at, "id", id, sizeof id );
        get_attribute( morph, "source", mesh, sizeof mesh );
        place_mesh( c, id, mesh );
        take_morph_controller( c, at, morph, end + 13, scene_end );
    }
}

// Takes the middle off the positions of geometries that are far from their origins and have no morph targets.
static void bring_near( Collada* c )
{
    char id[256];
    for ( const char* at = strstr( c->source->text, "<geometry" ); at != NULL; at = strstr( at + 1, "<geometry" ) )
    {
        const char *vertices, *end, *array = find_positions( c, at, &vertices, &end );
        const char *next = array != NULL ? strchr( array, '>' ) : NULL, *first = next;
        get_attribute( at, "id", id, sizeof id );
        double low[3] = { INFINITY, INFINITY, INFINITY }, high[3] = { -INFINITY, -INFINITY, -INFINITY }, origin[3];
        size_t count = 0, size = 0;
        for ( char* after; next != NULL; ++count, next = after - 1 )
        {
            double value = strtod( next + 1, &after );
            if ( after == next + 1 )
                break;
            low[count % 3] = fmin( low[count % 3], value );
            high[count % 3] = fmax( high[count % 3], value );
        }
        if ( count < 3 || count % 3 != 0 || !rf_is_far( low, high, origin ) ||
             rf_find_fact( c->source, RF_FACT_WEIGHT, id, 0 ) != NULL || rf_find_fact( c->source, RF_FACT_FAR, id, 0 ) != NULL )
            continue;
        char *text = malloc( 18 * count + 1 ), *after;
        next = first + 1;
        for ( size_t i = 0; text != NULL && i < count; ++i, next = after )
            size += (size_t)sprintf( text + size, "%.9g ", strtod( next, &after ) - origin[i % 3] );
        RfFact* fact = text != NULL ? rf_add_fact( c->source, RF_FACT_FAR, id, strlen( id ) ) : NULL;
        if ( fact != NULL )
        {
            memcpy( fact->values, origin, sizeof origin );
            add_edit( c, first + 1, (size_t)( next - first - 1 ), text );
        }
        free( text );
    }
}

static void mend( RfSource* source )
{
    Collada c = { .source = source };
    read_nodes( &c );
    int bent = 0;
    for ( const char* at = strstr( source->text, "<sampler " ); at != NULL; at = strstr( at + 1, "<sampler " ) )
    {
        const char* end = strstr( at, "</sampler>" );
        const char* words = end != NULL ? find_list( &c, at, end, "INTERPOLATION", "<Name_array" ) : NULL;
        size_t length = words != NULL ? strcspn( words, "<" ) : 0;
        const char* curve = words != NULL ? words + strspn( words, "LINEAR \t\r\n" ) : NULL;
        bent += curve != NULL && curve < words + length;
    }
    if ( bent > 0 )
        rf_warn( source->log, "%d curves of animations are cubic or stepped: they go straight between their keys", bent );
    const char* tool = strstr( source->text, "<authoring_tool>" );
    source->binds_at_rest = tool != NULL && strncmp( tool + 16, "Blender", 7 ) == 0;
    for ( const char* at = strstr( source->text, "<instance_controller" ); at != NULL;
          at = strstr( at + 1, "<instance_controller" ) )
        mend_skin( &c, at );
    mend_morphs( &c );
    bring_near( &c );
    if ( !source->failed )
        apply_edits( &c );
    for ( int i = 0; i < c.edit_count; ++i )
        free( c.edits[i].text );
    free( c.edits );
    free( c.nodes );
}

void rf_note_collada( RfSource* source )
{
    char id[256];
    for ( const char* at = strchr( source->text, '<' ); at != NULL; at = strchr( at + 1, '<' ) )
    {
        bool camera = strncmp( at, "<camera ", 8 ) == 0, light = strncmp( at, "<light ", 7 ) == 0;
        const char* end = camera ? strstr( at, "</camera>" ) : light ? strstr( at, "</light>" ) : NULL;
        if ( end == NULL )
            continue;
        get_attribute( at, "id", id, sizeof id );
        if ( camera )
            note_camera( source, at, end, id );
        else
            note_light( source, at, end, id );
        at = end;
    }
    if ( strlen( source->text ) == source->size )
        mend( source );
}

// MTL: `map_Kd -s 2 2 1 -o 0.5 0 0 -clamp on wood.png`.

static int slot_of( const char* word )
{
    static const struct
    {
        const char* word;
        int slot;
    } all[] = { { "map_Kd", 0 }, { "norm", 1 }, { "map_Kn", 1 }, { "map_Ke", 2 }, { "map_emissive", 2 } };
    for ( size_t i = 0; i < sizeof all / sizeof all[0]; ++i )
    {
        if ( strcasecmp( word, all[i].word ) == 0 )
            return all[i].slot;
    }
    return -1;
}

static void note_map( RfSource* source, const char* material, int slot, char* rest )
{
    double values[RF_FACT_VALUES] = { 1, 1, 0, 0, 0 };
    bool given = false;
    char *word = strtok_r( NULL, " \t\r", &rest ), *left = NULL;
    while ( word != NULL && word[0] == '-' )
    {
        double* target = strcmp( word, "-s" ) == 0 ? values : strcmp( word, "-o" ) == 0 ? values + 2 : NULL;
        bool clamp = strcmp( word, "-clamp" ) == 0;
        if ( target == NULL && !clamp && strcmp( word, "-blendu" ) != 0 && strcmp( word, "-blendv" ) != 0 )
            left = word;
        char *option = word, *end;
        word = strtok_r( NULL, " \t\r", &rest );
        if ( word != NULL && ( strcmp( word, "on" ) == 0 || strcmp( word, "off" ) == 0 ) )
        {
            values[4] = clamp ? strcmp( word, "on" ) == 0 : values[4];
            given = given || clamp;
            word = strtok_r( NULL, " \t\r", &rest );
        }
        for ( int i = 0; word != NULL && strcmp( option, "-imfchan" ) != 0; ++i, word = strtok_r( NULL, " \t\r", &rest ) )
        {
            double number = strtod( word, &end );
            if ( *end != 0 || i > 2 )
                break;
            if ( target != NULL && i < 2 )
                target[i] = number;
            given = given || target != NULL;
        }
        if ( word != NULL && strcmp( option, "-imfchan" ) == 0 )
            word = strtok_r( NULL, " \t\r", &rest );
    }
    if ( left != NULL )
        rf_warn( source->log, "material '%s': the option %s of its texture is left out", material, left );
    RfFact* fact = given ? rf_add_fact( source, RF_FACT_MAP, material, strlen( material ) ) : NULL;
    if ( fact == NULL )
        return;
    fact->slot = slot;
    memcpy( fact->values, values, sizeof values );
}

void rf_note_mtl( RfSource* source, const char* text )
{
    char material[256] = "", line[4096];
    for ( const char* at = text; *at != 0; )
    {
        size_t length = strcspn( at, "\n" );
        snprintf( line, sizeof line, "%.*s", (int)length, at );
        at += length + ( at[length] != 0 );
        char *rest = line, *word = strtok_r( rest, " \t\r", &rest );
        if ( word == NULL )
            continue;
        if ( strcmp( word, "newmtl" ) == 0 )
            snprintf( material, sizeof material, "%s", rest + strspn( rest, " \t" ) );
        material[strcspn( material, "\r" )] = 0;
        int slot = slot_of( word );
        if ( slot >= 0 )
            note_map( source, material, slot, rest );
    }
}
