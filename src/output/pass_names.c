// Names of passes: a table, and rules for light groups and for what is not in it.
#include "output/pass_names.h"

#include <stdio.h>
#include <string.h>

// A pass that Blender or Nuke has under a name of its own. NULL: not that program.
typedef struct Row
{
    const char* pass;
    const char* blender; // after "ViewLayer."
    int component[4];    // of the pass, of each of Blender's channels, from 1 on; below 0: negated. 0: in order
    const char* nuke[4]; // full names
} Row;

static const Row s_rows[] = {
    { .pass = RF_PASS_PICTURE, .blender = "Combined", .nuke = { "R", "G", "B" } },
    { .pass = "alpha", .blender = "Combined", .nuke = { "A" } },
    { .pass = "albedo", .blender = "DiffCol" },
    { .pass = "denoise_albedo", .blender = "Denoising Albedo" },
    { .pass = "denoise_normal", .blender = "Denoising Normal", .component = { 1, -3, 2 } },
    { .pass = "normal", .blender = "Normal", .component = { 1, -3, 2 } },
    { .pass = "depth", .blender = "Depth" },
    { .pass = "motion",
      .blender = "Vector",
      .component = { 1, 2, -3, -4 },
      .nuke = { "backward.u", "backward.v", "forward.u", "forward.v" } },
    { .pass = "emission", .blender = "Emit" },
    { .pass = "object_index", .blender = "IndexOB" },
    { .pass = "material_index", .blender = "IndexMA" },
};

#define ROWS ( sizeof s_rows / sizeof s_rows[0] )
#define LIGHT "light_"
#define BLENDER_LIGHT "Combined_"

static bool begins( const char* text, const char* with ) { return strncmp( text, with, strlen( with ) ) == 0; }

static const Row* find_row( const char* pass )
{
    for ( size_t i = 0; i < ROWS; ++i )
    {
        if ( strcmp( s_rows[i].pass, pass ) == 0 )
            return s_rows + i;
    }
    return NULL;
}

// Blender takes what is behind the last dot but one for the pass: there are none in its name.
static void put_blender_layer( const char* pass, char name[RF_PASS_CHANNEL_SIZE] )
{
    const Row* row = find_row( pass );
    bool light = row == NULL && begins( pass, LIGHT );
    const char* own = row != NULL ? row->blender : light ? pass + strlen( LIGHT ) : pass;
    size_t begin = strlen( RF_BLENDER_LAYER "." );
    snprintf( name, RF_PASS_CHANNEL_SIZE, RF_BLENDER_LAYER ".%s%.200s", light ? BLENDER_LIGHT : "", own );
    for ( char* c = name + begin; *c != '\0'; ++c )
        *c = *c == '.' ? '_' : *c;
}

void rf_name_pass_layer( RfPassNames names, const char* pass, char name[RF_PASS_CHANNEL_SIZE] )
{
    if ( names == RF_NAMES_BLENDER )
        put_blender_layer( pass, name );
    else
        snprintf( name, RF_PASS_CHANNEL_SIZE, "%.200s", pass );
}

static void name_blender_channel( const char* pass, const char* letters, int i, RfPassChannel* channel )
{
    const Row* row = find_row( pass );
    char layer[RF_PASS_CHANNEL_SIZE];
    int component = row != NULL ? row->component[i] : 0;
    put_blender_layer( pass, layer );
    snprintf( channel->name, sizeof channel->name, "%.240s.%c", layer, letters[i] );
    channel->component = component == 0 ? i : ( component < 0 ? -component : component ) - 1;
    channel->negated = component < 0;
}

void rf_name_pass_channel( RfPassNames names, const char* pass, const char* letters, int i, RfPassChannel* channel )
{
    if ( names == RF_NAMES_BLENDER )
    {
        name_blender_channel( pass, letters, i, channel );
        return;
    }
    const Row* row = find_row( pass );
    const char* nuke = names == RF_NAMES_NUKE && row != NULL ? row->nuke[i] : NULL;
    bool bare = pass[0] == '\0' || strcmp( pass, "alpha" ) == 0;
    *channel = ( RfPassChannel ){ .component = i };
    if ( nuke != NULL )
        snprintf( channel->name, sizeof channel->name, "%s", nuke );
    else
        snprintf( channel->name, sizeof channel->name, "%.200s%s%c", bare ? "" : pass, bare ? "" : ".", letters[i] );
}

// The end of a name, which may have anything and a dot before it.
static bool ends( const char* name, const char* tail )
{
    size_t length = strlen( name ), end = strlen( tail );
    return length >= end && strcmp( name + length - end, tail ) == 0 && ( length == end || name[length - end - 1] == '.' );
}

static bool is_blender_channel( const char* channel, const char* pass, char letter, bool* negated )
{
    static const char letters[] = "XYZW";
    const Row* row = find_row( pass );
    char layer[RF_PASS_CHANNEL_SIZE], tail[RF_PASS_CHANNEL_SIZE + 2];
    put_blender_layer( pass, layer );
    for ( int i = 0; row != NULL && row->component[0] != 0 && i < 4; ++i )
    {
        int component = row->component[i];
        if ( component == 0 || letters[( component < 0 ? -component : component ) - 1] != letter )
            continue;
        letter = letters[i];
        *negated = component < 0;
        break;
    }
    snprintf( tail, sizeof tail, "%s.%c", layer + strlen( RF_BLENDER_LAYER "." ), letter );
    return ends( channel, tail );
}

bool rf_is_pass_channel( const char* channel, const char* pass, char letter, bool* negated )
{
    static const char letters[] = "XYZW";
    const Row* row = find_row( pass );
    const char letter_text[] = { letter, '\0' };
    RfPassChannel own;
    rf_name_pass_channel( RF_NAMES_REFRAME, pass, letter_text, 0, &own );
    *negated = false;
    bool bare = strchr( own.name, '.' ) == NULL; // "R": at the end of many
    if ( bare ? strcmp( channel, own.name ) == 0 : ends( channel, own.name ) )
        return true;
    for ( int i = 0; row != NULL && !bare && i < 4; ++i )
    {
        if ( row->nuke[i] != NULL && letters[i] == letter && ends( channel, row->nuke[i] ) )
            return true;
    }
    if ( is_blender_channel( channel, pass, letter, negated ) )
        return true;
    *negated = false;
    return strcmp( pass, "depth" ) == 0 && ends( channel, "Depth.V" );
}
