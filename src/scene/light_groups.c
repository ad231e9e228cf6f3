// Tags of light, and the groups that a render asks for.
#include "scene/light_groups.h"

#include "base/json.h"
#include "base/try.h"
#include "base/words.h"
#include "scene/placement.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST_TAGS 65000
#define NAMES_LISTED 24
#define SKY_NAME "environment"

// Can a group be called so? 1 to 63 bytes, without commas and control characters.
static bool is_light_group_name( const char* name )
{
    size_t length = strlen( name );
    for ( size_t i = 0; i < length; ++i )
    {
        if ( (unsigned char)name[i] < 0x20 || name[i] == 0x7f || name[i] == ',' )
            return false;
    }
    return length > 0 && length < RF_LIGHT_GROUP_NAME_SIZE;
}

RfResult rf_read_light_group( const RfField* object, const char** name )
{
    RfField field = rf_field_member( object, "light_group" );
    *name = json_string_value( field.json );
    if ( field.json == NULL || ( *name != NULL && is_light_group_name( *name ) ) )
        return rf_json_result( object );
    return rf_field_must_be( &field, "a name of 1 to 63 bytes without commas" );
}

bool rf_tag_light( RfScene* scene, const char* name, uint16_t* tag )
{
    *tag = 0;
    if ( strcmp( name, RF_LIGHT_GROUP_REST ) == 0 )
        return true;
    for ( int i = 0; i < scene->light_group_count; ++i )
    {
        if ( strcmp( scene->light_groups[i], name ) == 0 )
        {
            *tag = (uint16_t)( i + 1 );
            return true;
        }
    }
    if ( scene->light_group_count >= MOST_TAGS )
        return false;
    char* copy = rf_make_room( &scene->light_groups, (size_t)scene->light_group_count, sizeof copy ) ? strdup( name ) : NULL;
    if ( copy == NULL )
        return false;
    scene->light_groups[scene->light_group_count++] = copy;
    *tag = (uint16_t)scene->light_group_count;
    return true;
}

static bool is_bright( RfVec3 light ) { return rf_max_component( light ) > 0.0f; }

bool rf_scene_light( const RfScene* scene, int index, RfLightInfo* info )
{
    *info = ( RfLightInfo ){ .group = -1 };
    int materials = (int)scene->material_count;
    if ( index < 0 || index > scene->punctual_count + materials )
        return false;
    uint16_t tag;
    if ( index < scene->punctual_count )
    {
        const RfPunctual* lamp = scene->punctuals + index;
        *info = ( RfLightInfo ){ .kind = "lamp", .name = lamp->name, .shines = is_bright( lamp->intensity ) };
        tag = lamp->light_group;
    }
    else if ( index < scene->punctual_count + materials )
    {
        const RfMaterial* material = scene->materials + ( index - scene->punctual_count );
        *info = ( RfLightInfo ){ .kind = "material", .name = material->name, .shines = rf_emits( material ) };
        tag = material->light_group;
    }
    else
    {
        *info = ( RfLightInfo ){ .kind = "sky", .name = SKY_NAME, .shines = is_bright( scene->environment.radiance ) };
        tag = scene->environment.light_group;
    }
    info->group = (int)tag - 1;
    return true;
}

// What is being grouped.
typedef struct Grouping
{
    const RfScene* scene;
    int count;    // of lights: lamps, materials, the environment
    bool* shines; // each, in triangles that are there
    int* group;   // of each; −1: none yet
    RfError* error;
    RfLightGroups* out;
} Grouping;

// What is dark as loaded may shine later.
static bool may_shine( const RfScene* scene, int index )
{
    int material = index - scene->punctual_count;
    if ( scene->movement == NULL )
        return false;
    if ( material < 0 )
        return scene->punctuals[index].changes;
    return material < (int)scene->material_count ? scene->materials[material].dims : scene->environment.changes;
}

// A material that no triangle has lights nothing.
static bool mark_shining( const Grouping* g )
{
    const RfScene* scene = g->scene;
    bool* used = calloc( (size_t)scene->material_count + 1, sizeof *used );
    bool some = false;
    RfLightInfo light;
    if ( used == NULL )
        return false;
    for ( uint32_t i = 0; i < scene->material_count; ++i )
        some = some || rf_emits( scene->materials + i ) || scene->materials[i].dims;
    if ( some )
        rf_mark_used_materials( scene, used );
    for ( int i = 0; rf_scene_light( scene, i, &light ); ++i )
    {
        int material = i - scene->punctual_count;
        bool shines = light.shines || may_shine( scene, i );
        g->shines[i] = shines && ( material < 0 || material >= (int)scene->material_count || used[material] );
        g->group[i] = -1;
    }
    free( used );
    return true;
}

static const char* tag_of( const RfScene* scene, const RfLightInfo* light )
{
    return light->group >= 0 ? scene->light_groups[light->group] : NULL;
}

static void append_name( const char* name, char* text, size_t size, int* listed )
{
    if ( *listed < NAMES_LISTED && strlen( text ) + strlen( name ) + 8 < size )
        rf_append( text, size, "%s'%s'", *listed > 0 ? ", " : "", name );
    *listed += 1;
}

// Appends a group of this name, or finds it. Beyond the most, groups are counted and have no name.
static int add_group( const Grouping* g, const char* name )
{
    for ( int i = 0; i < g->out->count && i < RF_LIGHT_GROUPS_MOST; ++i )
    {
        if ( strcmp( g->out->names[i], name ) == 0 )
            return i;
    }
    if ( g->out->count < RF_LIGHT_GROUPS_MOST )
        g->out->names[g->out->count] = name;
    return g->out->count++;
}

static RfResult fail_too_many( const Grouping* g )
{
    char text[600] = "";
    int listed = 0;
    for ( int i = 0; i < RF_LIGHT_GROUPS_MOST; ++i )
        append_name( g->out->names[i], text, sizeof text, &listed );
    return rf_fail( g->error, RF_ERROR_USAGE, "%s: more than %d light groups, after %s: ask for some by name", g->scene->path,
                    RF_LIGHT_GROUPS_MOST, text );
}

// Every light in the group of its tag, or of its own name.
static RfResult group_all( const Grouping* g, bool by_lamp )
{
    RfLightInfo light;
    for ( int i = 0; rf_scene_light( g->scene, i, &light ); ++i )
    {
        const char* name = by_lamp ? light.name : tag_of( g->scene, &light );
        if ( !g->shines[i] || name == NULL )
            continue;
        if ( !is_light_group_name( name ) )
            return rf_fail( g->error, RF_ERROR_USAGE,
                            "%s: %s '%.80s' has a name that no light group can have: give it a light_group and ask for that",
                            g->scene->path, light.kind, name );
        g->group[i] = add_group( g, name );
        if ( g->out->count > RF_LIGHT_GROUPS_MOST )
            return fail_too_many( g );
    }
    if ( g->out->count > 0 || ( !by_lamp && g->scene->light_group_count > 0 ) ) // the groups of exported scenes may be dark
        return RF_OK;
    return rf_fail( g->error, RF_ERROR_USAGE, "%s: %s", g->scene->path,
                    by_lamp ? "nothing in it shines, there are no light groups"
                            : "has no light groups: tag lights with light_group, or ask for lamps" );
}

static RfResult fail_unknown( const Grouping* g, const char* name )
{
    char text[500] = "", nearest[128] = "";
    int listed = 0;
    RfLightInfo light;
    for ( int pass = 0; pass < 2; ++pass )
    {
        int count = pass == 0 ? g->scene->light_group_count : g->count;
        for ( int i = 0; i < count; ++i )
        {
            const char* one = pass == 0 ? g->scene->light_groups[i] : NULL;
            if ( pass == 1 && rf_scene_light( g->scene, i, &light ) && g->shines[i] )
                one = light.name;
            if ( one == NULL )
                continue;
            if ( nearest[0] == '\0' && rf_nearest_word( name, &one, 1 ) != NULL )
                snprintf( nearest, sizeof nearest, "did you mean '%.60s'? ", one );
            append_name( one, text, sizeof text, &listed );
        }
    }
    return rf_fail( g->error, RF_ERROR_USAGE, "%s: no light group or light is called '%.60s': %sthere are %s%s", g->scene->path,
                    name, nearest, listed > 0 ? text : "none", listed > NAMES_LISTED ? " and more" : "" );
}

// The lights of a tag, else those of the name, that no name before has; an error where none is left.
static RfResult group_name( const Grouping* g, const char* name )
{
    RfLightInfo light;
    const char* kept = NULL;
    for ( int i = 0; kept == NULL && i < g->scene->light_group_count; ++i )
        kept = strcmp( g->scene->light_groups[i], name ) == 0 ? g->scene->light_groups[i] : NULL;
    bool by_tag = kept != NULL;
    for ( int i = 0; kept == NULL && rf_scene_light( g->scene, i, &light ); ++i )
    {
        bool is_light = g->shines[i] || strcmp( light.kind, "lamp" ) == 0;
        kept = is_light && strcmp( light.name, name ) == 0 ? light.name : NULL;
    }
    if ( kept == NULL )
        return fail_unknown( g, name );
    int before = g->out->count, group = add_group( g, kept ), taken = -1;
    bool any = false;
    if ( group < before )
        return rf_fail( g->error, RF_ERROR_USAGE, "light group '%.60s' is given twice", name );
    if ( g->out->count > RF_LIGHT_GROUPS_MOST )
        return fail_too_many( g );
    for ( int i = 0; rf_scene_light( g->scene, i, &light ); ++i )
    {
        const char* own = by_tag ? tag_of( g->scene, &light ) : light.name;
        if ( own == NULL || strcmp( own, kept ) != 0 )
            continue;
        if ( g->group[i] >= 0 )
            taken = g->group[i];
        else
            g->group[i] = group;
        any = any || g->group[i] == group;
    }
    return any || taken < 0
               ? RF_OK
               : rf_fail( g->error, RF_ERROR_USAGE, "light '%.60s' is in light group '%.60s' already: leave one of them out",
                          name, g->out->names[taken] );
}

static RfResult group_names( const Grouping* g, const char* asked )
{
    for ( const char* at = asked; at != NULL; )
    {
        size_t length = strcspn( at, "," );
        char name[RF_LIGHT_GROUP_NAME_SIZE];
        snprintf( name, sizeof name, "%.*s", (int)( length < sizeof name ? length : sizeof name - 1 ), at );
        if ( strcmp( name, RF_LIGHT_GROUP_REST ) == 0 )
            return rf_fail( g->error, RF_ERROR_USAGE,
                            "light group '%s' cannot be asked for: it is there wherever some light is in no other",
                            RF_LIGHT_GROUP_REST );
        RF_TRY( group_name( g, name ) );
        at = at[length] == ',' ? at + length + 1 : NULL;
    }
    return RF_OK;
}

// What is in no group is in the rest, if it shines; where no group shines the rest is there alone.
static RfResult finish( const Grouping* g )
{
    RfLightGroups* out = g->out;
    bool left = false;
    for ( int i = 0; i < g->count; ++i )
        left = left || ( g->shines[i] && g->group[i] < 0 );
    int rest = left || out->count == 0 ? add_group( g, RF_LIGHT_GROUP_REST ) : 0;
    if ( out->count > RF_LIGHT_GROUPS_MOST )
        return fail_too_many( g );
    int punctuals = g->scene->punctual_count;
    for ( int i = 0; i < g->count; ++i )
    {
        uint8_t group = (uint8_t)( g->group[i] >= 0 ? g->group[i] : rest );
        if ( i < punctuals )
            out->punctual[i] = group;
        else if ( i < g->count - 1 )
            out->material[i - punctuals] = group;
        else
            out->sky = group;
    }
    return RF_OK;
}

static RfResult group_lights( const Grouping* g, const char* asked )
{
    RfLightGroups* out = g->out;
    out->punctual = malloc( (size_t)g->scene->punctual_count + 1 );
    out->material = malloc( (size_t)g->scene->material_count + 1 );
    if ( g->shines == NULL || g->group == NULL || out->punctual == NULL || out->material == NULL || !mark_shining( g ) )
        return rf_fail( g->error, RF_ERROR_MEMORY, "%s: out of memory for its light groups", g->scene->path );
    bool lamps = strcmp( asked, "lamps" ) == 0;
    RfResult result = lamps || strcmp( asked, "all" ) == 0 ? group_all( g, lamps ) : group_names( g, asked );
    return result == RF_OK ? finish( g ) : result;
}

RfResult rf_find_light_groups( const RfScene* scene, const char* asked, RfLightGroups* groups, RfError* error )
{
    *groups = ( RfLightGroups ){ 0 };
    if ( asked == NULL )
        return RF_OK;
    Grouping g = {
        .scene = scene, .count = scene->punctual_count + (int)scene->material_count + 1, .error = error, .out = groups
    };
    g.shines = calloc( (size_t)g.count, sizeof *g.shines );
    g.group = calloc( (size_t)g.count, sizeof *g.group );
    RfResult result = group_lights( &g, asked );
    free( g.shines );
    free( g.group );
    if ( result != RF_OK )
        rf_destroy_light_groups( groups );
    return result;
}

void rf_destroy_light_groups( RfLightGroups* groups )
{
    free( groups->punctual );
    free( groups->material );
    *groups = ( RfLightGroups ){ 0 };
}
