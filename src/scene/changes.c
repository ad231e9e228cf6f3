// Lists what changes besides the shapes and places of objects.
#include "scene/changes.h"

#include "scene/movement.h"
#include "scene/textured.h"

#include <stdlib.h>
#include <string.h>

const char* rf_changing_kind( RfChangingKind kind )
{
    static const char* const s_names[] = { "light", "material", "sky", "lens" };
    return s_names[kind];
}

static const char* const s_textures[RF_TEXTURE_SLOT_COUNT] = {
    "base colour texture",
    "metallic-roughness texture",
    "normal texture",
    "emissive texture",
    "specular texture",
    "specular colour texture",
    "transmission texture",
    "clear coat texture",
    "clear coat roughness texture",
    "clear coat normal texture",
    "sheen colour texture",
    "sheen roughness texture",
    "anisotropy texture",
    "film texture",
    "film thickness texture",
    "through texture",
    "through colour texture",
};

static const char* word_of( const RfChange* change )
{
    const char* word = rf_changed_traits( change->value )->word;
    return word != NULL ? word : s_textures[change->slot];
}

// Once.
static void add_word( RfChanging* to, const char* word )
{
    for ( int i = 0; i < to->what_count; ++i )
    {
        if ( strcmp( to->what[i], word ) == 0 )
            return;
    }
    if ( to->what_count < RF_MOST_CHANGES )
        to->what[to->what_count++] = word;
}

static bool places( const RfScene* scene, int node )
{
    for ( int i = 0; i < scene->channel_count; ++i )
    {
        if ( scene->channels[i].node == node && scene->channels[i].path <= RF_SCALE && rf_channel_varies( scene->channels + i ) )
            return true;
    }
    return false;
}

static RfChanging of_lamp( const RfScene* scene, const RfMovingLamp* lamp )
{
    const RfMovement* movement = scene->movement;
    RfChanging out = {
        .kind = RF_CHANGING_LIGHT, .number = lamp->punctual, .name = scene->punctuals[lamp->punctual].name, .shines = true
    };
    bool switched = false;
    for ( int i = lamp->node; i >= 0; i = movement->nodes[i].parent )
    {
        out.moves = out.moves || places( scene, movement->nodes[i].node );
        switched = switched || movement->nodes[i].shows >= 0;
    }
    if ( out.moves )
        add_word( &out, "place" );
    if ( switched )
        add_word( &out, "visibility" );
    for ( int i = 0; i < RF_CHANGED_LAMP_VALUES; ++i )
    {
        if ( lamp->changes[i] >= 0 )
            add_word( &out, word_of( movement->changes + lamp->changes[i] ) );
    }
    return out;
}

// Marks the materials of what moves.
static void mark_moving( const RfScene* scene, bool* moving )
{
    for ( int i = scene->still_placement_count; i < scene->placement_count; ++i )
    {
        const RfTriangles* t = &scene->meshes[scene->placements[i].mesh].triangles;
        for ( uint32_t k = 0; k < t->count; ++k )
            moving[t->material[k]] = true;
    }
}

static RfChanging of_material( const RfScene* scene, int number, bool moving )
{
    const RfMaterial* material = scene->materials + number;
    RfChanging out = { .kind = RF_CHANGING_MATERIAL,
                       .number = number,
                       .name = material->name,
                       .moves = moving && !material->changes, // whose surfaces count as moving, wherever they are
                       .shines = rf_max_component( material->emission ) > 0.0f };
    if ( out.moves && out.shines )
        add_word( &out, "place" );
    for ( int i = 0; i < scene->movement->change_count; ++i )
    {
        const RfChange* change = scene->movement->changes + i;
        if ( rf_is_of_material( change->value ) && change->of == number )
            add_word( &out, word_of( change ) );
    }
    for ( int slot = 0; material->textured != NULL && slot < RF_TEXTURE_SLOT_COUNT; ++slot )
    {
        int texture = material->textured->refs[slot].texture;
        if ( texture >= 0 && scene->textures[texture].plays )
            add_word( &out, s_textures[slot] );
    }
    return out;
}

static RfChanging of_sky( const RfScene* scene )
{
    RfChanging out = { .kind = RF_CHANGING_SKY, .name = "sky", .shines = true };
    for ( int i = 0; i < scene->movement->change_count; ++i )
    {
        if ( rf_is_of_sky( scene->movement->changes[i].value ) )
            add_word( &out, word_of( scene->movement->changes + i ) );
    }
    return out;
}

static int list_materials( const RfScene* scene, bool* moving, RfChanging* list )
{
    int count = 0;
    mark_moving( scene, moving );
    for ( uint32_t i = 0; i < scene->material_count; ++i )
    {
        const RfMaterial* m = scene->materials + i;
        bool shines = rf_max_component( m->emission ) > 0.0f; // else it may have been left out
        if ( m->changes || ( shines && ( m->dims || moving[i] ) ) )
            list[count++] = of_material( scene, (int)i, moving[i] );
    }
    return count;
}

static int list_lenses( const RfScene* scene, RfChanging* list )
{
    int count = 0;
    for ( int i = 0; i < scene->camera_count; ++i )
    {
        const RfCamera* camera = scene->cameras + i;
        if ( camera->zoom == NULL )
            continue;
        list[count] = ( RfChanging ){ .kind = RF_CHANGING_LENS, .number = i, .name = camera->name };
        add_word( list + count++, word_of( camera->zoom ) );
    }
    return count;
}

int rf_list_changing( const RfScene* scene, RfChanging** out )
{
    const RfMovement* movement = scene->movement;
    size_t lamps = movement != NULL ? (size_t)movement->lamp_count : 0;
    bool* moving = calloc( (size_t)scene->material_count + 1, sizeof *moving );
    RfChanging* list = calloc( lamps + scene->material_count + (size_t)scene->camera_count + 1, sizeof *list );
    int count = 0;
    *out = list;
    if ( list == NULL || moving == NULL )
    {
        free( moving );
        free( list );
        *out = NULL;
        return -1;
    }
    for ( size_t i = 0; i < lamps; ++i )
        list[count++] = of_lamp( scene, movement->lamps + i );
    if ( movement != NULL )
        count += list_materials( scene, moving, list + count );
    if ( movement != NULL && scene->environment.changes )
        list[count++] = of_sky( scene );
    count += list_lenses( scene, list + count );
    free( moving );
    return count;
}
