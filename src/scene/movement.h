// What moves and changes in a scene, and by which nodes and keys: the reader fills it, scene/pose.h evaluates it at a time.
#ifndef REFRAME_SCENE_MOVEMENT_H
#define REFRAME_SCENE_MOVEMENT_H

#include "scene/scene.h"
#include "scene/textured.h"

// A node that movers or joints hang on.
typedef struct RfMovingNode
{
    int node;   // of the scene
    int parent; // of this list, where it comes before; −1: a root
    int shows;  // channel that shows and hides it, or −1
} RfMovingNode;

typedef struct RfSkin
{
    int joint_count;
    int* joints;           // moving nodes
    RfMat4* inverse_binds; // from the mesh's space into that of the joint
} RfSkin;

// What one placement follows. Surfaces of a material that changes are placements that move, wherever they are.
typedef struct RfMover
{
    int node;          // moving node that shows and hides it, and places it unless a skin does
    RfMat4 local;      // within the node: of its instance
    int skin;          // −1: none
    int target_count;  // morph targets of its mesh
    double* weights;   // owned: of these where no channel animates them; NULL without targets
    int weights_moved; // channel that does, or −1
    bool flattens;     // its matrix may lose a dimension, and is then applied to a copy of the mesh
    bool settles;      // it is applied at all times: for what stands still, while it is read
} RfMover;

// What has a value.
typedef enum RfValueOwner
{
    RF_OF_LAMP, // punctual
    RF_OF_MATERIAL,
    RF_OF_TEXTURE, // of a material: KHR_texture_transform
    RF_OF_SKY,
    RF_OF_CAMERA, // its lens, where it moves with its node: the camera has the keys itself (scene/scene.h)
} RfValueOwner;

// A value that is not of a node: a row of rf_changed_traits.
typedef enum RfChangedValue
{
    RF_CHANGED_INTENSITY,
    RF_CHANGED_COLOR,
    RF_CHANGED_RANGE,
    RF_CHANGED_INNER_CONE, // radians
    RF_CHANGED_OUTER_CONE,
    RF_CHANGED_BASE_COLOR,
    RF_CHANGED_METALLIC,
    RF_CHANGED_ROUGHNESS,
    RF_CHANGED_EMISSIVE,
    RF_CHANGED_EMISSIVE_STRENGTH,
    RF_CHANGED_SPECULAR, // from here on they do not change
    RF_CHANGED_SPECULAR_COLOR,
    RF_CHANGED_IOR,
    RF_CHANGED_TRANSMISSION,
    RF_CHANGED_THICKNESS,
    RF_CHANGED_ATTENUATION_DISTANCE,
    RF_CHANGED_ATTENUATION_COLOR,
    RF_CHANGED_CLEARCOAT,
    RF_CHANGED_CLEARCOAT_ROUGHNESS,
    RF_CHANGED_SHEEN_COLOR,
    RF_CHANGED_SHEEN_ROUGHNESS,
    RF_CHANGED_THROUGH,
    RF_CHANGED_THROUGH_COLOR,
    RF_CHANGED_ANISOTROPY,
    RF_CHANGED_ANISOTROPY_ROTATION,
    RF_CHANGED_FILM,
    RF_CHANGED_FILM_IOR,
    RF_CHANGED_FILM_LEAST,
    RF_CHANGED_FILM_MOST,
    RF_CHANGED_DISPERSION,
    RF_CHANGED_MULTISCATTER,
    RF_CHANGED_SCATTER_ANISOTROPY,
    RF_CHANGED_ALPHA_CUTOFF,
    RF_CHANGED_TEXTURE_OFFSET,
    RF_CHANGED_TEXTURE_ROTATION,
    RF_CHANGED_TEXTURE_SCALE,
    RF_CHANGED_SKY_STRENGTH, // a factor on its radiance
    RF_CHANGED_SKY_RADIANCE, // another, for each channel
    RF_CHANGED_SKY_ROTATION, // radians
    RF_CHANGED_YFOV,
    RF_CHANGED_YMAG,
    RF_CHANGED_COUNT
} RfChangedValue;

#define RF_CHANGED_LAMP_VALUES ( RF_CHANGED_OUTER_CONE + 1 )

// The numbers of a punctual light.
typedef struct RfLampValues
{
    double intensity, color[3], range, cone[2]; // cone: inner and outer
} RfLampValues;

// The numbers of a material.
typedef struct RfMaterialValues
{
    RfFactors lobes;
    double emissive[3], strength;
    double transmission, thickness;                    // of glass; m, 0: thin-walled
    double attenuation_distance, attenuation_color[3]; // at which light is attenuated to the color
    double clearcoat, clearcoat_roughness;
    double multiscatter[3], scatter_anisotropy;
    double alpha_cutoff;
} RfMaterialValues;

static inline RfVec3 rf_emission_of( const RfMaterialValues* m ) { return rf_vec3_of( m->emissive, m->strength ); }

enum
{
    RF_VALUE_ABOVE = 1,     // `low` itself is excluded
    RF_VALUE_LIMITED = 2,   // `high` is a limit of this program
    RF_VALUE_ANIMATED = 4,  // KHR_animation_pointer changes it
    RF_VALUE_IN_FILE = 8,   // scene files override it
    RF_VALUE_KEYED = 16,    // and give it keys
    RF_VALUE_OF_MODEL = 32, // it is of glTF's own scattering model
    RF_VALUE_DEGREES = 64   // scene files have it in degrees
};

// All there is to know of a value, for the reader of glTF, scene files, animations and poses.
typedef struct RfChangedTraits
{
    const char* name; // in glTF and scene files
    RfValueOwner owner;
    size_t offset;    // in the struct of its owner's values; of textures in offset, rotation, scale
    const char* home; // what of its owner has it, an extension where it begins with KHR_; NULL: the owner itself
    int components;
    double low, high; // of each component
    unsigned flags;
    const char* word;           // what changes are called; NULL: there are none, or as the texture
    double file_low, file_high; // the range in scene files; both 0: low to high
} RfChangedTraits;

const RfChangedTraits* rf_changed_traits( RfChangedValue value );

// The next value of an owner after `value`, for loops that begin with −1; RF_CHANGED_COUNT after the last.
RfChangedValue rf_next_value( RfValueOwner owner, int value );

// Its place in the struct of its owner's values.
static inline double* rf_value_in( void* values, RfChangedValue value )
{
    return (double*)(void*)( (char*)values + rf_changed_traits( value )->offset );
}

// The path of a member in glTF from its owner on, such as "extensions/KHR_materials_ior/ior"; `home` as in the traits.
#define RF_VALUE_PATH 96
void rf_member_path( const char* home, const char* name, char path[RF_VALUE_PATH] );

static inline bool rf_is_of_sky( RfChangedValue value ) { return rf_changed_traits( value )->owner == RF_OF_SKY; }

static inline bool rf_is_of_material( RfChangedValue value )
{
    RfValueOwner owner = rf_changed_traits( value )->owner;
    return owner == RF_OF_MATERIAL || owner == RF_OF_TEXTURE;
}

// Changes the sky: its value is `v`.
void rf_change_sky( RfEnvironment* sky, RfChangedValue value, const double* v );

typedef struct RfChange
{
    RfChangedValue value;
    int of;            // number of the material; of a light: the first that has it; of the sky: 0
    int slot;          // of a texture: RfTextureSlot
    RfChannel channel; // owned; its node is −1, its path RF_VALUE
} RfChange;

// A change at `time` seconds. A spline that leaves the range between its keys is held at the end of the range.
void rf_sample_change( const RfChange* change, double time, double value[4] );

// The most of each component at any time.
void rf_most_of_change( const RfChange* change, double most[4] );

// A value of a material in the place of that of its file, which nothing there changes.
typedef struct RfOverride
{
    RfChangedValue value;
    int material;
    double numbers[4];
} RfOverride;

// A punctual light that moves, is switched or changes.
typedef struct RfMovingLamp
{
    int punctual;
    int node;                            // moving node that places, shows and hides it; −1: it stands still
    int changes[RF_CHANGED_LAMP_VALUES]; // of the movement, by value; −1: none
    RfLampValues values;                 // as in the file, where no change has them
} RfMovingLamp;

// A material that dims or changes.
typedef struct RfMovingMaterial
{
    int material;
    int first_change, change_count;             // of the movement
    RfMaterialValues values;                    // as in the file, where no change has them
    double transform[RF_TEXTURE_SLOT_COUNT][5]; // of its textures: offset, rotation, scale
} RfMovingMaterial;

typedef struct RfMovement
{
    int node_count;
    RfMovingNode* nodes; // parents first
    int skin_count;
    RfSkin* skins;
    int mover_count;
    RfMover* movers; // of the placements that move, in their order
    int lamp_count;
    RfMovingLamp* lamps;
    int material_count;
    RfMovingMaterial* materials;
    int change_count;
    RfChange* changes; // owned; those of a material one after the other
    int sequence_count;
    struct RfImageSequence* sequences; // owned: what textures show one after the other
    double start, end;                 // seconds: first and last key of all that moves or changes
} RfMovement;

// The scene's movement, which is made where there is none. NULL: there is no memory.
RfMovement* rf_open_movement( RfScene* scene );

// Gives the scene a change, with its keys, and widens the span of its movement. False: there is no memory, and the keys are freed.
bool rf_add_change( RfScene* scene, RfChange* change );

// Gives the scene a sequence, which it then owns. False: there is no memory.
bool rf_add_sequence( RfScene* scene, struct RfImageSequence* sequence );

// Destroys the movement where nothing moves or changes.
void rf_drop_empty_movement( RfScene* scene );

// NULL is allowed.
void rf_destroy_movement( RfMovement* movement );

// The value of a channel at `time` seconds of the scene, clamped to its first and last key: as many numbers as it has components, a
// unit quaternion for rotations.
void rf_sample_channel( const RfChannel* channel, double time, double* value );

// From when to when a channel moves, in seconds of the scene, which begins at 0: of what loops, the first round.
void rf_channel_span( const RfChannel* channel, double* start, double* end );

// Whether its value is not the same at all times.
bool rf_channel_varies( const RfChannel* channel );

// Copies a channel with its keys, which are to be freed also where that fails.
RfResult rf_copy_channel( const RfChannel* from, RfChannel* to, RfError* error );

// The channels of one node, contiguous in `scene->channels`, which are sorted by node, then path. Returns
// the first, and their number in `count` (0 to 5).
const RfChannel* rf_node_channels( const RfScene* scene, int node, int* count );

// The matrix of a node relative to its parent at `time` seconds.
void rf_node_local_matrix( const RfScene* scene, int node, double time, RfMat4* matrix );

#endif
