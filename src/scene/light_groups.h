// Light groups: what a render splits its light by, each lamp, emitting material and the environment in one of them. A scene names
// some by tags; others are made of the names of its lamps.
#ifndef REFRAME_SCENE_LIGHT_GROUPS_H
#define REFRAME_SCENE_LIGHT_GROUPS_H

#include "scene/scene.h"

#define RF_LIGHT_GROUPS_MOST 16     // of a render, with the rest
#define RF_LIGHT_GROUP_NAME_SIZE 64 // bytes, with the end

#define RF_LIGHT_GROUP_REST "rest"

typedef struct RfLightGroups
{
    int count;                               // 0: light is not split
    const char* names[RF_LIGHT_GROUPS_MOST]; // unique; the scene's, or "rest", which comes last: of light that is in no other
    uint8_t* punctual;                       // the group of each punctual light of the scene, below `count`; owned
    uint8_t* material;                       // of what each material emits; owned
    uint8_t sky;                             // of the environment
} RfLightGroups;

// The groups that `asked` stands for (RfRenderSettings.light_groups; NULL: none).
//
//     "all"     those that the scene names, without those in which nothing shines
//     "lamps"   each lamp and each material that emits by its name, and "environment"; those of one name are one group
//     names     by comma: of tags, else of lights; a light is in the first that it belongs to, groups may be dark
//
// What shines in none of them is in "rest", if anything does. Fails with RF_ERROR_USAGE for names that nothing has (naming the
// nearest, and those there are) or that come twice, for more than RF_LIGHT_GROUPS_MOST groups and for none; with RF_ERROR_MEMORY.
// `groups` is to be destroyed, except on failure.
RfResult rf_find_light_groups( const RfScene* scene, const char* asked, RfLightGroups* groups, RfError* error );
void rf_destroy_light_groups( RfLightGroups* groups );

// Reads the member "light_group" of an object; NULL: there is none.
struct RfField;
RfResult rf_read_light_group( const struct RfField* object, const char** name );

// The number of a tag in the scene's list plus 1, added where it is new; 0 for "rest". False: there is no memory, or too many.
bool rf_tag_light( RfScene* scene, const char* name, uint16_t* tag );

#endif
