// Skins, morph targets and animations of assimp's scene.
#include "import/assimp_import.h"

#include "base/try.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Skins. Until the nodes are there, joints are numbers of bones, and after them the node of the mesh.

static bool is_first( const struct aiMesh* from, unsigned bone )
{
    for ( unsigned i = 0; i < bone; ++i ) // FBX files may list one bone twice, and assimp then has it twice
    {
        if ( from->mBones[i] == from->mBones[bone] )
            return false;
    }
    return true;
}

// Keeps the largest weights of a vertex, sorted; returns the one that found no place.
static float insert_weight( uint16_t* influences, float* weights, uint16_t bone, float weight )
{
    for ( int i = 0; i < RF_MODEL_INFLUENCES; ++i )
    {
        if ( weights[i] >= weight )
            continue;
        float other = weights[i];
        uint16_t other_bone = influences[i];
        weights[i] = weight;
        influences[i] = bone;
        weight = other;
        bone = other_bone;
    }
    return weight;
}

// Makes the weights 1 in all; what hangs on nothing goes with the node of the mesh.
static void normalize_weights( uint16_t* influences, float* weights, uint16_t own )
{
    double sum = 0.0;
    for ( int i = 0; i < RF_MODEL_INFLUENCES; ++i )
        sum += (double)weights[i];
    if ( !( sum > 1e-6 ) )
    {
        weights[0] = 1.0f;
        influences[0] = own;
        return;
    }
    for ( int i = 0; i < RF_MODEL_INFLUENCES; ++i )
        weights[i] = (float)( (double)weights[i] / sum );
}

static bool take_weights( RfImport* import, const struct aiMesh* from, RfModelMesh* mesh )
{
    size_t room = (size_t)RF_MODEL_INFLUENCES * from->mNumVertices;
    RfModelSkin* skin = mesh->skin = calloc( 1, sizeof *skin );
    if ( skin == NULL )
        return false;
    skin->influences = calloc( room + 1, sizeof *skin->influences );
    skin->weights = calloc( room + 1, sizeof *skin->weights );
    if ( skin->influences == NULL || skin->weights == NULL )
        return false;
    float lost = 0.0f;
    for ( unsigned b = 0; b < from->mNumBones; ++b )
    {
        const struct aiBone* bone = from->mBones[b];
        for ( unsigned i = 0; is_first( from, b ) && i < bone->mNumWeights; ++i )
        {
            size_t at = (size_t)RF_MODEL_INFLUENCES * bone->mWeights[i].mVertexId;
            float weight = bone->mWeights[i].mWeight;
            if ( at < room && weight > 0.0f && isfinite( weight ) )
                lost = fmaxf( lost, insert_weight( skin->influences + at, skin->weights + at, (uint16_t)b, weight ) );
        }
    }
    for ( size_t i = 0; i < room; i += RF_MODEL_INFLUENCES )
        normalize_weights( skin->influences + i, skin->weights + i, (uint16_t)from->mNumBones );
    if ( lost > 0.0f )
        rf_warn( import->log, "mesh '%s': more than %d bones move a vertex: the others are left out, the largest weight is %.3g",
                 rf_name_in_file( import->source, from->mName.data ), RF_MODEL_INFLUENCES, (double)lost );
    return true;
}

// Morph targets.

// Whether target i is of the same FBX channel as the one after it: a shape in between.
static bool is_in_between( const RfImport* import, const struct aiMesh* from, unsigned i )
{
    return import->source->format == RF_SOURCE_FBX && i + 1 < from->mNumAnimMeshes &&
           strcmp( from->mAnimMeshes[i]->mName.data, from->mAnimMeshes[i + 1]->mName.data ) == 0;
}

// A target at the vertices of its mesh.
typedef struct Target
{
    const char* name;
    const struct aiVector3D *positions, *normals; // the latter may be NULL
    bool relative;
} Target;

// What a target adds to the normals; NULL where it adds nothing, as in files that do not have it.
static float* copy_normal_steps( const Target* target, const RfModelMesh* mesh )
{
    size_t count = mesh->vertex_count;
    float* out = malloc( 3 * count * sizeof *out );
    float most = 0.0f;
    for ( size_t i = 0; out != NULL && i < count; ++i )
    {
        const struct aiVector3D* n = target->normals + i;
        const float* base = mesh->normals + 3 * i;
        float x = n->x, y = n->y, z = n->z, length = sqrtf( x * x + y * y + z * z );
        float scale = target->relative ? 1.0f : length > 0.0f ? 1.0f / length : 0.0f;
        float less = target->relative || scale == 0.0f ? 0.0f : 1.0f;
        const float steps[3] = { scale * x - less * base[0], scale * y - less * base[1], scale * z - less * base[2] };
        for ( int k = 0; k < 3; ++k )
        {
            out[3 * i + (size_t)k] = isfinite( steps[k] ) ? steps[k] : 0.0f;
            most = fmaxf( most, fabsf( out[3 * i + (size_t)k] ) );
        }
    }
    if ( most > 1e-4f )
        return out;
    free( out );
    return NULL;
}

static bool take_morph( const RfImport* import, const struct aiMesh* from, const Target* target, RfModelMesh* mesh )
{
    RfModelMorph* morph = mesh->morphs + mesh->morph_count++;
    double unit = import->source->unit;
    size_t count = from->mNumVertices;
    morph->name = *target->name != 0 ? strdup( target->name ) : NULL;
    char* dot = morph->name != NULL ? strchr( morph->name, '.' ) : NULL;
    if ( import->source->format == RF_SOURCE_FBX && dot != NULL &&
         rf_find_fact( import->source, RF_FACT_WEIGHT, morph->name, 0 ) == NULL )
        *dot = 0; // assimp 5.4 appends the name of the shape
    morph->positions = malloc( 3 * count * sizeof *morph->positions );
    for ( size_t i = 0; morph->positions != NULL && i < count; ++i )
    {
        const struct aiVector3D *to = target->positions + i, *at = from->mVertices + i;
        double less = target->relative ? 0.0 : 1.0;
        morph->positions[3 * i] = (float)( unit * ( (double)to->x - less * (double)at->x ) );
        morph->positions[3 * i + 1] = (float)( unit * ( (double)to->y - less * (double)at->y ) );
        morph->positions[3 * i + 2] = (float)( unit * ( (double)to->z - less * (double)at->z ) );
    }
    if ( mesh->normals != NULL && target->normals != NULL )
        morph->normals = copy_normal_steps( target, mesh );
    return morph->positions != NULL;
}

static bool take_morphs( RfImport* import, const struct aiMesh* from, RfModelMesh* mesh )
{
    mesh->morphs = calloc( (size_t)from->mNumAnimMeshes + 1, sizeof *mesh->morphs );
    bool good = mesh->morphs != NULL;
    int between = 0, odd = 0;
    for ( unsigned i = 0; good && i < from->mNumAnimMeshes; ++i )
    {
        const struct aiAnimMesh* target = from->mAnimMeshes[i];
        const Target t = { target->mName.data, target->mVertices, target->mNormals, false };
        between += is_in_between( import, from, i );
        if ( is_in_between( import, from, i ) )
            continue;
        if ( target->mVertices == NULL || target->mNumVertices != from->mNumVertices )
            odd += 1;
        else
            good = take_morph( import, from, &t, mesh );
    }
    const char* name = rf_name_in_file( import->source, from->mName.data );
    if ( between > 0 )
        rf_warn( import->log, "mesh '%s': %d shapes in between others are left out: shape keys go straight to their last", name,
                 between );
    if ( odd > 0 )
        rf_warn( import->log, "mesh '%s': its morph targets are left out: %d of them have another number of vertices", name,
                 odd );
    if ( odd > 0 ) // weights go by number
        mesh->morph_count = 0;
    return good;
}

// assimp makes a mesh of each material of a Collada mesh, and of its targets, which have the same faces: the one of a target that
// is like `mesh`; NULL: there is none.
static const struct aiMesh* find_target( const struct aiScene* scene, const struct aiMesh* mesh, const char* name )
{
    unsigned number = 0, count = 0, at = 0;
    char full[512];
    snprintf( full, sizeof full, RF_TARGET_NODE "%s", name );
    for ( unsigned i = 0; i < scene->mNumMeshes && scene->mMeshes[i] != mesh; ++i )
        number += strcmp( scene->mMeshes[i]->mName.data, mesh->mName.data ) == 0;
    for ( unsigned i = 0; i < scene->mNumMeshes; ++i )
        count += strcmp( scene->mMeshes[i]->mName.data, full ) == 0;
    for ( unsigned i = 0; i < scene->mNumMeshes && count > 0; ++i )
    {
        const struct aiMesh* found = scene->mMeshes[i];
        if ( strcmp( found->mName.data, full ) == 0 && at++ == number % count )
            return found->mNumVertices == mesh->mNumVertices ? found : NULL;
    }
    return NULL;
}

// Collada's targets are meshes of their own. Their normals are those of the faces.
static bool take_collada_morphs( RfImport* import, const struct aiMesh* from, RfModelMesh* mesh )
{
    int count = 0, odd = 0;
    while ( rf_find_fact( import->source, RF_FACT_WEIGHT, from->mName.data, count ) != NULL )
        ++count;
    mesh->morphs = count > 0 ? calloc( (size_t)count, sizeof *mesh->morphs ) : NULL;
    bool good = count == 0 || mesh->morphs != NULL;
    for ( int i = 0; good && i < count; ++i )
    {
        const RfFact* fact = rf_find_fact( import->source, RF_FACT_WEIGHT, from->mName.data, i );
        const struct aiMesh* target = fact->text != NULL ? find_target( import->scene, from, fact->text ) : NULL;
        odd += target == NULL || target->mVertices == NULL;
        if ( target == NULL || target->mVertices == NULL )
            continue;
        const Target t = { fact->text, target->mVertices, NULL, fact->values[1] != 0.0 };
        good = take_morph( import, from, &t, mesh );
    }
    if ( odd > 0 )
        rf_warn( import->log, "mesh '%s': its morph targets are left out: %d of them have other vertices", from->mName.data,
                 odd );
    if ( odd > 0 )
        mesh->morph_count = 0;
    return good;
}

bool rf_take_pose( RfImport* import, const struct aiMesh* from, RfModelMesh* mesh )
{
    if ( from->mNumBones > 0 && from->mNumBones < UINT16_MAX && !take_weights( import, from, mesh ) )
        return false;
    if ( import->source->format == RF_SOURCE_COLLADA )
        return take_collada_morphs( import, from, mesh );
    return from->mNumAnimMeshes == 0 || take_morphs( import, from, mesh );
}

// Joints.

typedef struct Joints
{
    RfModelSkin* skin;
    RfMat4* binds; // their inverse bind matrices
} Joints;

// The joint of a node with this matrix, a new one where there is none. glTF has a node only once in a skin: with another
// matrix a node below stands for it. −1: out of memory.
static int find_joint( RfImport* import, Joints* joints, int node, const RfMat4* bind )
{
    RfModelSkin* skin = joints->skin;
    bool taken = false;
    for ( int i = 0; i < skin->joint_count; ++i )
    {
        int joint = skin->joints[i];
        bool same = memcmp( joints->binds + i, bind, sizeof *bind ) == 0;
        if ( same &&
             ( joint == node || ( import->model->nodes[joint].parent == node && import->model->nodes[joint].name == NULL ) ) )
            return i;
        taken = taken || joint == node;
    }
    const RfMat4 identity = rf_mat4_identity();
    if ( taken )
        node = rf_import_node( import, "", node, &identity );
    if ( node < 0 )
        return -1;
    joints->binds[skin->joint_count] = *bind;
    skin->joints[skin->joint_count] = node;
    return skin->joint_count++;
}

// The geometric transformation of an FBX node, which its meshes have and its bones do not know of.
static RfMat4 geometric_matrix( const RfImport* import, const struct aiNode* node )
{
    RfMat4 out = rf_mat4_identity();
    for ( const struct aiNode* up = node->mParent; up != NULL && strstr( up->mName.data, "_$AssimpFbx$_" ) != NULL;
          up = up->mParent )
    {
        RfMat4 part = rf_import_matrix( import, &up->mTransformation );
        if ( strstr( up->mName.data, "_$AssimpFbx$_Geometric" ) != NULL )
            out = rf_mat4_mul( &part, &out );
    }
    return out;
}

// From the space of an armature into that of a joint of it, as they rest.
static RfMat4 rest_matrix( const RfImport* import, int node )
{
    RfMat4 rest = rf_mat4_identity(), out = rf_mat4_identity();
    for ( ; node >= 0; node = import->model->nodes[node].parent )
    {
        const RfModelNode* joint = import->model->nodes + node;
        if ( joint->name == NULL || rf_find_fact( import->source, RF_FACT_JOINT, joint->name, 0 ) == NULL )
            break;
        rest = rf_mat4_mul( &joint->matrix, &rest );
    }
    double det = rf_mat4_det3( &rest ), place[3];
    if ( !( fabs( det ) > 0.0 ) || !isfinite( det ) )
        return out;
    for ( int r = 0; r < 3; ++r )
    {
        const double axis[3] = { r == 0, r == 1, r == 2 };
        double row[3];
        rf_mat4_apply_cofactor( &rest, axis, row );
        for ( int c = 0; c < 3; ++c )
            out.m[4 * c + r] = row[c] / det;
    }
    rf_mat4_apply( &out, rest.m + 12, 0.0, place );
    for ( int i = 0; i < 3; ++i )
        out.m[12 + i] = -place[i];
    return out;
}

// The inverse bind matrix of a bone.
static RfMat4 bind_matrix( const RfImport* import, const RfPosed* posed, const struct aiBone* bone )
{
    RfMat4 out = rf_import_matrix( import, &bone->mOffsetMatrix );
    char name[2048];
    snprintf( name, sizeof name, "%s\n%s", posed->from->mName.data, bone->mName.data );
    const RfFact* fact = import->source->format == RF_SOURCE_FBX ? rf_find_fact( import->source, RF_FACT_BIND, name, 0 ) : NULL;
    for ( int i = 0; fact != NULL && i < 16; ++i )
        out.m[i] = fact->values[i] * ( i >= 12 && i < 15 ? import->source->unit : 1.0 );
    return out;
}

static bool import_skin( RfImport* import, const RfPosed* posed, RfModelMesh* mesh, const char** missing )
{
    const struct aiMesh* from = posed->mesh;
    RfModelSkin* skin = mesh->skin;
    size_t room = (size_t)from->mNumBones + 1;
    skin->joints = malloc( room * sizeof *skin->joints );
    int* joint_of = malloc( room * sizeof *joint_of );
    Joints joints = { skin, malloc( room * sizeof *joints.binds ) };
    bool good = skin->joints != NULL && joint_of != NULL && joints.binds != NULL;
    const RfMat4 identity = rf_mat4_identity(), geometric = geometric_matrix( import, posed->from );
    for ( size_t b = 0; good && b < room; ++b )
        joint_of[b] = -1;
    size_t influences = (size_t)RF_MODEL_INFLUENCES * mesh->vertex_count;
    for ( size_t i = 0; good && i < influences; ++i )
    {
        uint16_t b = skin->influences[i];
        if ( skin->weights[i] > 0.0f && joint_of[b] < 0 )
        {
            int node = b < from->mNumBones ? rf_find_import_node( import, from->mBones[b]->mName.data ) : posed->node;
            RfMat4 bind = b < from->mNumBones && node >= 0 ? bind_matrix( import, posed, from->mBones[b] ) : identity;
            RfMat4 away = identity;
            memcpy( away.m + 12, import->origins[mesh - import->model->meshes], 3 * sizeof( double ) );
            RfMat4 rest = b < from->mNumBones && import->source->binds_at_rest ? rest_matrix( import, node ) : identity;
            if ( b < from->mNumBones && node >= 0 )
            {
                bind = rf_mat4_mul( &rest, &bind );
                bind = rf_mat4_mul( &bind, &geometric );
            }
            bind = rf_mat4_mul( &bind, &away );
            if ( node < 0 )
                *missing = from->mBones[b]->mName.data;
            joint_of[b] = find_joint( import, &joints, node >= 0 ? node : posed->node, &bind );
            good = joint_of[b] >= 0;
        }
        skin->influences[i] = skin->weights[i] > 0.0f && good ? (uint16_t)joint_of[b] : 0;
    }
    skin->inverse_binds = good ? malloc( 16 * room * sizeof *skin->inverse_binds ) : NULL;
    for ( int i = 0; skin->inverse_binds != NULL && i < 16 * skin->joint_count; ++i )
        skin->inverse_binds[i] = (float)joints.binds[i / 16].m[i % 16];
    free( joint_of );
    free( joints.binds );
    return skin->inverse_binds != NULL;
}

static float weight_of( const RfImport* import, const struct aiMesh* from, const RfModelMesh* mesh, int target )
{
    bool collada = import->source->format == RF_SOURCE_COLLADA;
    const char* name = collada ? from->mName.data : mesh->morphs[target].name;
    const RfFact* fact = rf_find_fact( import->source, RF_FACT_WEIGHT, name != NULL ? name : "", collada ? target : 0 );
    if ( fact != NULL )
        return isfinite( fact->values[0] ) ? (float)fact->values[0] : 0.0f;
    return (unsigned)target < from->mNumAnimMeshes && import->source->format != RF_SOURCE_FBX ? from->mAnimMeshes[target]->mWeight
                                                                                              : 0.0f;
}

RfResult rf_import_skins( RfImport* import, RfError* error )
{
    RfModel* model = import->model;
    const char* missing = NULL;
    for ( int i = 0; i < import->posed_count; ++i )
    {
        const RfPosed* posed = import->posed + i;
        RfModelMesh* mesh = model->meshes + model->nodes[posed->node].meshes[0];
        bool good = true;
        if ( mesh->skin != NULL && mesh->skin->joints == NULL )
            good = import_skin( import, posed, mesh, &missing );
        RfModelNode* node = model->nodes + posed->node;
        if ( good && mesh->morph_count > 0 )
            good = ( node->weights = malloc( (size_t)mesh->morph_count * sizeof *node->weights ) ) != NULL;
        if ( !good )
            return rf_fail( error, RF_ERROR_MEMORY, RF_IMPORT_MEMORY );
        for ( int k = 0; k < mesh->morph_count; ++k )
            node->weights[k] = weight_of( import, posed->mesh, mesh, k );
    }
    for ( int i = 0; i < model->mesh_count; ++i )
    {
        // of no node: such a mesh is not in the picture
        RfModelSkin* skin = model->meshes[i].skin;
        if ( skin == NULL || skin->joints != NULL )
            continue;
        free( skin->influences );
        free( skin->weights );
        free( skin );
        model->meshes[i].skin = NULL;
    }
    if ( missing != NULL )
        rf_warn( import->log, "bone '%s': is not in the file: what hangs on it goes with its mesh", missing );
    return RF_OK;
}

// Animations.

// Adds a track with room for `keys` keys, and one at 0 s.
static RfModelTrack* add_track( RfModelAnimation* animation, int node, int path, int width, size_t keys )
{
    RfModelTrack* track = animation->tracks + animation->track_count;
    *track = ( RfModelTrack ){ .node = node, .path = path, .width = width };
    track->times = malloc( ( keys + 1 ) * sizeof *track->times );
    track->values = malloc( ( keys + 1 ) * (size_t)width * sizeof *track->values );
    animation->track_count += 1; // freed with the model
    return track->times != NULL && track->values != NULL ? track : NULL;
}

// Appends a key. glTF begins at 0 s and has one key at a time: of keys before 0 s, the last is moved to it, half-way if the next
// is after.
static void add_key( RfModelTrack* track, double time, const double* values, double* last_time )
{
    size_t width = (size_t)track->width, last = (size_t)track->key_count - 1;
    if ( !isfinite( time ) || time > 1e9 )
        return;
    if ( track->key_count > 0 && *last_time < 0.0 )
    {
        double part = time > 0.0 ? -*last_time / ( time - *last_time ) : 1.0;
        for ( size_t i = 0; i < width; ++i )
        {
            float* value = track->values + last * width + i;
            *value += (float)part * ( (float)values[i] - *value );
        }
        *last_time = time;
        if ( time <= 0.0 )
            return;
    }
    if ( track->key_count > 0 && (float)time <= track->times[last] )
        return;
    track->times[track->key_count] = time > 0.0 ? (float)time : 0.0f;
    for ( size_t i = 0; i < width; ++i )
        track->values[(size_t)track->key_count * width + i] = (float)values[i];
    track->key_count += 1;
    *last_time = time;
}

// Makes quaternions unit and neighbours alike, and a track that stands still one key.
static void tidy_track( RfModelTrack* track )
{
    size_t width = (size_t)track->width;
    bool still = true;
    for ( int i = 0; i < track->key_count; ++i )
    {
        float *value = track->values + (size_t)i * width, *before = value - width;
        if ( track->path == RF_MODEL_ROTATION )
        {
            double q[4] = { (double)value[0], (double)value[1], (double)value[2], (double)value[3] }, dot = 0.0;
            rf_quat_normalize( q );
            for ( int k = 0; i > 0 && k < 4; ++k )
                dot += q[k] * (double)before[k];
            for ( int k = 0; k < 4; ++k )
                value[k] = (float)( dot < 0.0 ? -q[k] : q[k] );
        }
        still = still && ( i == 0 || memcmp( value, before, width * sizeof *value ) == 0 );
    }
    if ( still && track->key_count > 0 )
    {
        track->key_count = 1;
        track->times[0] = 0.0f;
    }
}

// Whether a track only says what its node has anyway.
static bool is_at_rest( const RfModel* model, const RfModelTrack* track )
{
    double rest[3][4];
    if ( track->key_count != 1 || track->path == RF_MODEL_WEIGHTS )
        return track->key_count == 0;
    rf_split_matrix( &model->nodes[track->node].matrix, rest[RF_MODEL_TRANSLATION], rest[RF_MODEL_ROTATION],
                     rest[RF_MODEL_SCALE] );
    double sign = 1.0, size = 1e-3, dot = 0.0;
    for ( int i = 0; i < track->width; ++i )
    {
        dot += rest[track->path][i] * (double)track->values[i];
        size = fmax( size, fabs( rest[track->path][i] ) );
    }
    sign = track->path == RF_MODEL_ROTATION && dot < 0.0 ? -1.0 : 1.0;
    for ( int i = 0; i < track->width; ++i )
    {
        if ( !( fabs( rest[track->path][i] - sign * (double)track->values[i] ) <= 1e-6 * size ) )
            return false;
    }
    return true;
}

static void drop_track( RfModelAnimation* animation )
{
    RfModelTrack* track = animation->tracks + --animation->track_count;
    free( track->times );
    free( track->values );
}

typedef struct Clock
{
    double ticks; // per second
    double start; // in ticks
} Clock;

static double seconds_of( const Clock* clock, double time ) { return ( time - clock->start ) / clock->ticks; }

static bool take_channel( RfImport* import, const struct aiNodeAnim* from, const Clock* clock, int node,
                          RfModelAnimation* animation )
{
    RfModel* model = import->model;
    const unsigned counts[3] = { from->mNumPositionKeys, from->mNumRotationKeys, from->mNumScalingKeys };
    for ( int path = 0; path < 3; ++path )
    {
        RfModelTrack* track = add_track( animation, node, path, path == RF_MODEL_ROTATION ? 4 : 3, counts[path] );
        if ( track == NULL )
            return false;
        double last = 0.0;
        for ( unsigned i = 0; i < counts[path]; ++i )
        {
            const struct aiQuatKey* q = from->mRotationKeys + i;
            const struct aiVectorKey* v = ( path == RF_MODEL_SCALE ? from->mScalingKeys : from->mPositionKeys ) + i;
            double unit = path == RF_MODEL_TRANSLATION ? import->source->unit : 1.0;
            bool turn = path == RF_MODEL_ROTATION;
            double values[4] = { 0, 0, 0, 0 };
            values[0] = turn ? (double)q->mValue.x : unit * (double)v->mValue.x;
            values[1] = turn ? (double)q->mValue.y : unit * (double)v->mValue.y;
            values[2] = turn ? (double)q->mValue.z : unit * (double)v->mValue.z;
            values[3] = turn ? (double)q->mValue.w : 0.0;
            // one key alone is a constant, whose time does not matter
            add_key( track, counts[path] > 1 ? seconds_of( clock, turn ? q->mTime : v->mTime ) : 0.0, values, &last );
        }
        tidy_track( track );
        // with several animations, each says all of a node that it moves, since all play at once
        if ( track->key_count == 0 || ( import->scene->mNumAnimations == 1 && is_at_rest( model, track ) ) )
            drop_track( animation );
    }
    return true;
}

// A weight at a time: linear between the keys that have it.
static double weight_at( const struct aiMeshMorphAnim* from, unsigned target, double time, double otherwise )
{
    double before = 0.0, value = otherwise;
    bool found = false;
    for ( unsigned i = 0; i < from->mNumKeys; ++i )
    {
        const struct aiMeshMorphKey* key = from->mKeys + i;
        for ( unsigned k = 0; k < key->mNumValuesAndWeights; ++k )
        {
            if ( key->mValues[k] != target )
                continue;
            double next = key->mWeights[k];
            if ( found && key->mTime >= time )
                return key->mTime > before ? value + ( next - value ) * ( time - before ) / ( key->mTime - before ) : next;
            if ( key->mTime >= time )
                return next;
            found = true;
            before = key->mTime;
            value = next;
        }
    }
    return value;
}

static bool take_weights_track( const RfImport* import, const struct aiMeshMorphAnim* from, const Clock* clock,
                                const RfPosed* posed, RfModelAnimation* animation )
{
    const RfModelNode* node = import->model->nodes + posed->node;
    int count = import->model->meshes[node->meshes[0]].morph_count;
    RfModelTrack* track = count > 0 ? add_track( animation, posed->node, RF_MODEL_WEIGHTS, count, from->mNumKeys ) : NULL;
    double *values = malloc( ( (size_t)count + 1 ) * sizeof *values ), last = 0.0;
    for ( unsigned i = 0; track != NULL && values != NULL && i < from->mNumKeys; ++i )
    {
        for ( int k = 0; k < count; ++k )
            values[k] = weight_at( from, (unsigned)k, from->mKeys[i].mTime, (double)node->weights[k] );
        add_key( track, seconds_of( clock, from->mKeys[i].mTime ), values, &last );
    }
    bool good = values != NULL && ( track != NULL || count == 0 );
    free( values );
    if ( track != NULL )
        tidy_track( track );
    if ( track != NULL && track->key_count == 0 )
        drop_track( animation );
    return good;
}

static int compare_keys( const void* a, const void* b )
{
    const struct aiMeshMorphKey *left = a, *right = b;
    return ( left->mTime > right->mTime ) - ( left->mTime < right->mTime );
}

// FBX calls the channels of a mesh after its node and a number, "face*0".
static bool is_channel_of( const struct aiMeshMorphAnim* channel, const struct aiNode* node )
{
    size_t length = strlen( node->mName.data );
    const char* rest = channel->mName.data + length;
    if ( strncmp( channel->mName.data, node->mName.data, length ) != 0 )
        return false;
    return *rest == 0 || ( *rest == '*' && strspn( rest + 1, "0123456789" ) == strlen( rest + 1 ) );
}

// assimp 5.2 takes 10^10 ticks off the keys of an FBX file that has only weights.
static double start_of( const struct aiAnimation* from )
{
    double first = 0.0;
    for ( unsigned i = 0; i < from->mNumMorphMeshChannels; ++i )
    {
        const struct aiMeshMorphAnim* channel = from->mMorphMeshChannels[i];
        for ( unsigned k = 0; k < channel->mNumKeys; ++k )
            first = fmin( first, channel->mKeys[k].mTime );
    }
    return first < -1e9 ? first : 0.0;
}

static bool import_animation( RfImport* import, const struct aiAnimation* from, RfModelAnimation* animation, int* lost )
{
    const Clock clock = { from->mTicksPerSecond > 0.0 ? from->mTicksPerSecond : 25.0, start_of( from ) };
    size_t room = 3 * (size_t)from->mNumChannels + (size_t)from->mNumMorphMeshChannels * (size_t)import->posed_count + 1;
    animation->name = rf_import_text( &from->mName );
    animation->tracks = calloc( room, sizeof *animation->tracks );
    bool good = animation->tracks != NULL;
    for ( unsigned i = 0; good && i < from->mNumChannels; ++i )
    {
        int node = rf_find_import_node( import, from->mChannels[i]->mNodeName.data );
        *lost += node < 0;
        good = node < 0 || take_channel( import, from->mChannels[i], &clock, node, animation );
    }
    for ( unsigned i = 0; good && i < from->mNumMorphMeshChannels; ++i )
    {
        int found = 0;
        for ( int k = 0; good && k < import->posed_count; ++k )
        {
            const RfPosed* posed = import->posed + k;
            if ( !is_channel_of( from->mMorphMeshChannels[i], posed->from ) )
                continue;
            ++found;
            good = take_weights_track( import, from->mMorphMeshChannels[i], &clock, posed, animation );
        }
        *lost += found == 0;
    }
    return good;
}

// Weights of Collada's morph targets, which assimp does not animate: a track for each mesh, in an animation of their own.
static bool import_weight_keys( RfImport* import, RfModelAnimation* animation )
{
    const RfSource* source = import->source;
    animation->tracks = calloc( (size_t)import->posed_count + 1, sizeof *animation->tracks );
    bool good = animation->tracks != NULL;
    for ( int p = 0; good && p < import->posed_count; ++p )
    {
        const RfPosed* posed = import->posed + p;
        const RfModelNode* node = import->model->nodes + posed->node;
        int count = import->model->meshes[node->meshes[0]].morph_count, keys = 0;
        for ( int i = 0; i < source->fact_count; ++i )
            keys += source->facts[i].kind == RF_FACT_KEY && strcmp( source->facts[i].name, posed->mesh->mName.data ) == 0;
        if ( keys == 0 || count == 0 )
            continue;
        struct aiMeshMorphKey* all = calloc( (size_t)keys, sizeof *all );
        unsigned* slots = calloc( (size_t)keys, sizeof *slots );
        double* weights = calloc( (size_t)keys, sizeof *weights );
        good = all != NULL && slots != NULL && weights != NULL;
        for ( int i = 0, k = 0; good && i < source->fact_count; ++i )
        {
            const RfFact* fact = source->facts + i;
            if ( fact->kind != RF_FACT_KEY || strcmp( fact->name, posed->mesh->mName.data ) != 0 )
                continue;
            slots[k] = (unsigned)fact->slot;
            weights[k] = fact->values[1];
            all[k] = ( struct aiMeshMorphKey ){ fact->values[0], slots + k, weights + k, 1 };
            ++k;
        }
        if ( good )
            qsort( all, (size_t)keys, sizeof *all, compare_keys );
        const struct aiMeshMorphAnim channel = { .mNumKeys = (unsigned)keys, .mKeys = all };
        const Clock clock = { 1.0, 0.0 };
        good = good && take_weights_track( import, &channel, &clock, posed, animation );
        free( all );
        free( slots );
        free( weights );
    }
    return good;
}

RfResult rf_import_animations( RfImport* import, RfError* error )
{
    RfModel* model = import->model;
    int lost = 0;
    model->animations = calloc( (size_t)import->scene->mNumAnimations + 2, sizeof *model->animations );
    bool good = model->animations != NULL;
    for ( unsigned i = 0; good && i < import->scene->mNumAnimations + 1; ++i )
    {
        RfModelAnimation* animation = model->animations + model->animation_count++;
        if ( i < import->scene->mNumAnimations )
            good = import_animation( import, import->scene->mAnimations[i], animation, &lost );
        else
            good = import_weight_keys( import, animation );
        if ( !good || animation->track_count > 0 )
            continue;
        free( animation->tracks );
        free( animation->name );
        *animation = ( RfModelAnimation ){ 0 };
        model->animation_count -= 1;
    }
    if ( lost > 0 )
        rf_warn( import->log, "%d channels of animations are left out: what they move is not in the file", lost );
    return good ? RF_OK : rf_fail( error, RF_ERROR_MEMORY, RF_IMPORT_MEMORY );
}
