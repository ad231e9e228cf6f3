// reframe convert: what of OBJ, Collada and FBX arrives in the scene.
#include "support/cli_run.h"
#include "support/scene_files.h"
#include "support/test.h"

#include "scene/textured.h"

static const RfMaterial* material_of( const RfScene* scene, const char* name )
{
    for ( uint32_t i = 0; i < scene->material_count; ++i )
    {
        if ( scene->materials[i].name != NULL && strcmp( scene->materials[i].name, name ) == 0 )
            return scene->materials + i;
    }
    fail_msg( "there is no material '%s'", name );
    return NULL;
}

static void check_obj_materials( const RfScene* scene )
{
    const RfMaterial* wall = material_of( scene, "wall" );
    assert_int_equal( wall->kind, RF_BSDF_GGX );
    assert_true( wall->textured != NULL );
    assert_true( convert_near( wall->alpha, 0.25 ) ); // sqrt( 2 / 32 )
    assert_true( wall->double_sided );
    const RfMaterial* lamp = material_of( scene, "lamp" );
    assert_true( convert_near( lamp->emission.x, 12 ) && convert_near( lamp->emission.y, 6 ) &&
                 convert_near( lamp->emission.z, 3 ) );
    assert_false( lamp->double_sided );
    const RfMaterial* glass = material_of( scene, "glass" );
    assert_int_equal( glass->kind, RF_BSDF_GLASS );
    assert_true( convert_near( glass->ior, 1.33 ) && convert_near( glass->tint.y, 0.9 ) );
    const RfMaterial* gold = material_of( scene, "gold" );
    assert_true( convert_near( gold->specular.x, 0.9 ) && convert_near( gold->specular.z, 0.25 ) &&
                 convert_near( gold->diffuse.x, 0 ) );
}

TEST_WITHIN( test_obj_arrives, convert_enter, convert_leave )
{
    convert_write_obj();
    const CliResult* run = cli_run( "$R convert a.obj a.glb --json a.json" );
    cli_expect( run, 0, "warning: 1 points and lines are left out" );
    assert_non_null( strstr( run->out, "a.glb: 5 triangles in 4 meshes" ) );
    size_t size;
    AUTO_FREE char* json = cli_read( "a.json", &size );
    assert_non_null( strstr( json, "\"triangles\": 5" ) );
    assert_non_null( strstr( json, "\"warnings\": 1" ) );
    AUTO_SCENE scene = convert_load( "a.glb" );
    assert_int_equal( scene.triangles.count, 5 );
    convert_assert_point( &scene.bounds_min.x, 0, 0, 0 );
    convert_assert_point( &scene.bounds_max.x, 2, 3, 0 );
    assert_int_equal( scene.texture_count, 1 );
    assert_true( scene.textures->width == 2 && scene.textures->bytes[0] == 255 && scene.textures->bytes[5] == 255 );
    check_obj_materials( &scene );
    int seen = 0; // v runs down in glTF: the corner at 0 3 0 had 0.75
    for ( uint32_t i = 0; i < scene.triangles.vertex_count; ++i )
    {
        const float* p = scene.triangles.positions + 3 * i;
        const float* uv = scene.triangles.uvs + 2 * i;
        if ( p[0] == 0.0f && p[1] == 3.0f && ++seen > 0 )
            assert_true( convert_near( uv[0], 0 ) && convert_near( uv[1], 0.25 ) );
    }
    assert_true( seen > 0 );
    convert_assert_files( 5 );
}

TEST_WITHIN( test_placement_arrives, convert_enter, convert_leave )
{
    convert_write_obj();
    cli_expect( cli_run( "$R convert a.obj a.glb --up z --scale 0.5 --quiet" ), 0, NULL );
    AUTO_SCENE scene = convert_load( "a.glb" );
    convert_assert_point( &scene.bounds_min.x, 0, 0, -1.5 ); // y went to −z
    convert_assert_point( &scene.bounds_max.x, 1, 0, 0 );
    assert_true( convert_near( scene.triangles.normals[1], 1 ) );
}

#define COLLADA( kind, optics, points )                                                                                          \
    "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\">"                  \
    "<asset><unit name=\"half\" meter=\"0.5\"/><up_axis>Z_UP</up_axis></asset>"                                                  \
    "<library_cameras><camera id=\"eye\" name=\"eye\"><optics><technique_common><" kind ">" optics                               \
    "<znear>0.1</znear><zfar>100</zfar></" kind "></technique_common></optics></camera></library_cameras>"                       \
    "<library_lights><light id=\"spot\" name=\"spot\"><technique_common><spot><color>4 2 2</color>"                              \
    "<falloff_angle>60</falloff_angle></spot></technique_common></light></library_lights>"                                       \
    "<library_geometries><geometry id=\"g\" name=\"g\"><mesh><source id=\"p\">"                                                  \
    "<float_array id=\"pa\" count=\"9\">" points "</float_array><technique_common>"                                              \
    "<accessor source=\"#pa\" count=\"3\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/>"     \
    "<param name=\"Z\" type=\"float\"/></accessor></technique_common></source>"                                                  \
    "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices><triangles count=\"1\">"                          \
    "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>"     \
    "<library_visual_scenes><visual_scene id=\"s\">"                                                                             \
    "<node id=\"tri\" name=\"tri\"><translate>1 2 3</translate><instance_geometry url=\"#g\"/></node>"                           \
    "<node id=\"eye\" name=\"eye\"><translate>0 -5 1</translate><rotate>1 0 0 90</rotate><instance_camera url=\"#eye\"/></node>" \
    "<node id=\"lamp\" name=\"lamp\"><translate>0 0 4</translate><instance_light url=\"#spot\"/></node>"                         \
    "</visual_scene></library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>"

#define POINTS "0 0 0 1 0 0 0 0 1"

// The way of a node up to the root.
static RfMat4 world_of( const RfScene* scene, int node )
{
    RfMat4 world = rf_mat4_identity();
    for ( ; node >= 0; node = scene->nodes[node].parent )
    {
        const RfNode* n = scene->nodes + node;
        RfMat4 local = n->has_matrix ? n->matrix : rf_mat4_from_trs( n->translation, n->rotation, n->scale );
        world = rf_mat4_mul( &local, &world );
    }
    return world;
}

TEST_WITHIN( test_collada_arrives, convert_enter, convert_leave )
{
    convert_write( "c.dae", COLLADA( "perspective", "<xfov>60</xfov><aspect_ratio>2</aspect_ratio>", POINTS ) );
    cli_expect( cli_run( "$R convert c.dae c.glb" ), 0, "candela or lux" );
    assert_non_null( strstr( cli_run( "$R convert c.dae z.glb --up z" )->err, "turned once more" ) );
    RfScene scene = convert_load( "c.glb" );
    assert_int_equal( scene.triangles.count, 1 );
    convert_assert_point( &scene.bounds_min.x, 0.5, 1.5, -1 ); // z up, in half metres
    convert_assert_point( &scene.bounds_max.x, 1, 2, -1 );
    assert_int_equal( scene.camera_count, 1 );
    assert_true( convert_near( scene.cameras->yfov, 2 * atan( tan( 0.5235987755982988 ) / 2 ) ) );
    RfMat4 eye = world_of( &scene, scene.cameras->node );
    assert_true( convert_near( eye.m[12], 0 ) && convert_near( eye.m[13], 0.5 ) && convert_near( eye.m[14], 2.5 ) ); // once
    assert_true( convert_near( eye.m[10], 0.5 ) && convert_near( eye.m[5], 0.5 ) ); // along −z, y up
    assert_int_equal( scene.punctual_count, 1 );
    const RfPunctual* lamp = scene.punctuals;
    assert_int_equal( lamp->kind, RF_PUNCTUAL_SPOT );
    convert_assert_point( &lamp->position.x, 0, 2, 0 );
    convert_assert_point( &lamp->direction.x, 0, -1, 0 );
    convert_assert_point( &lamp->intensity.x, 4, 2, 2 );
    assert_true( convert_near( lamp->cos_outer, cos( 0.5235987755982988 ) ) );
    rf_destroy_scene( &scene );
    convert_write( "d.dae", COLLADA( "perspective", "<yfov>40</yfov>", POINTS ) ); // without a ratio assimp has no angle
    cli_expect( cli_run( "$R convert d.dae d.glb --quiet" ), 0, NULL );
    scene = convert_load( "d.glb" );
    assert_true( convert_near( scene.cameras->yfov, 40 * 3.14159265358979 / 180 ) );
    rf_destroy_scene( &scene );
    convert_write( "o.dae", COLLADA( "orthographic", "<xmag>3</xmag><aspect_ratio>2</aspect_ratio>", POINTS ) );
    cli_expect( cli_run( "$R convert o.dae o.glb --scale 2 --quiet" ), 0, NULL );
    scene = convert_load( "o.glb" );
    assert_int_equal( scene.cameras->projection, RF_ORTHOGRAPHIC );
    assert_true( convert_near( scene.cameras->ymag, 1.5 ) ); // half of what is seen, in units of half a metre, twice
    rf_destroy_scene( &scene );
    convert_write( "e.dae", COLLADA( "perspective", "<xfov>60</xfov>", POINTS ) );
    const CliResult* run = cli_run( "$R convert e.dae e.glb" );
    assert_int_equal( run->status, 0 );
    assert_non_null( strstr( run->err, "camera 'eye': is left out: its field of view is unknown" ) );
}

// As exporters write it, in text: centimetres, z up, a camera whose position
// stands in its node and in itself.
static const char s_fbx[] = "; FBX 7.4.0 project file\n"
                            "FBXHeaderExtension:  {\n"
                            "FBXHeaderVersion: 1003\n"
                            "FBXVersion: 7400\n"
                            "}\n"
                            "GlobalSettings:  {\n"
                            "Version: 1000\n"
                            "Properties70:  {\n"
                            "P: \"UpAxis\", \"int\", \"Integer\", \"\",2\n"
                            "P: \"UpAxisSign\", \"int\", \"Integer\", \"\",1\n"
                            "P: \"FrontAxis\", \"int\", \"Integer\", \"\",1\n"
                            "P: \"FrontAxisSign\", \"int\", \"Integer\", \"\",-1\n"
                            "P: \"CoordAxis\", \"int\", \"Integer\", \"\",0\n"
                            "P: \"CoordAxisSign\", \"int\", \"Integer\", \"\",1\n"
                            "P: \"UnitScaleFactor\", \"double\", \"Number\", \"\",1\n"
                            "}\n"
                            "}\n"
                            "Objects:  {\n"
                            "Geometry: 100, \"Geometry::tri\", \"Mesh\" {\n"
                            "Vertices: *9 {\n"
                            "a: 0,0,0,100,0,0,0,100,0\n"
                            "}\n"
                            "PolygonVertexIndex: *3 {\n"
                            "a: 0,1,-3\n"
                            "}\n"
                            "GeometryVersion: 124\n"
                            "LayerElementMaterial: 0 {\n"
                            "Version: 101\n"
                            "Name: \"\"\n"
                            "MappingInformationType: \"AllSame\"\n"
                            "ReferenceInformationType: \"IndexToDirect\"\n"
                            "Materials: *1 {\n"
                            "a: 0\n"
                            "}\n"
                            "}\n"
                            "Layer: 0 {\n"
                            "Version: 100\n"
                            "LayerElement:  {\n"
                            "Type: \"LayerElementMaterial\"\n"
                            "TypedIndex: 0\n"
                            "}\n"
                            "}\n"
                            "}\n"
                            "Model: 200, \"Model::tri\", \"Mesh\" {\n"
                            "Version: 232\n"
                            "Properties70:  {\n"
                            "P: \"Lcl Translation\", \"Lcl Translation\", \"\", \"A\",100,200,300\n"
                            "}\n"
                            "}\n"
                            "NodeAttribute: 300, \"NodeAttribute::cam\", \"Camera\" {\n"
                            "Properties70:  {\n"
                            "P: \"Position\", \"Vector\", \"\", \"A\",0,0,500\n"
                            "P: \"AspectWidth\", \"double\", \"Number\", \"\",200\n"
                            "P: \"AspectHeight\", \"double\", \"Number\", \"\",100\n"
                            "P: \"FieldOfView\", \"FieldOfView\", \"\", \"A\",60\n"
                            "P: \"ApertureMode\", \"enum\", \"\", \"\",1\n"
                            "}\n"
                            "TypeFlags: \"Camera\"\n"
                            "}\n"
                            "Model: 400, \"Model::cam\", \"Camera\" {\n"
                            "Version: 232\n"
                            "Properties70:  {\n"
                            "P: \"Lcl Translation\", \"Lcl Translation\", \"\", \"A\",0,0,500\n"
                            "P: \"Lcl Rotation\", \"Lcl Rotation\", \"\", \"A\",0,90,0\n"
                            "}\n"
                            "}\n"
                            "Material: 500, \"Material::m\", \"\" {\n"
                            "Version: 102\n"
                            "ShadingModel: \"phong\"\n"
                            "Properties70:  {\n"
                            "P: \"DiffuseColor\", \"Color\", \"\", \"A\",0.5,0.25,0.125\n"
                            "P: \"EmissiveColor\", \"Color\", \"\", \"A\",4,2,1\n"
                            "P: \"EmissiveFactor\", \"Number\", \"\", \"A\",1\n"
                            "P: \"SpecularColor\", \"Color\", \"\", \"A\",0.5,0.5,0.5\n"
                            "P: \"ShininessExponent\", \"Number\", \"\", \"A\",30\n"
                            "}\n"
                            "}\n"
                            "NodeAttribute: 600, \"NodeAttribute::lamp\", \"Light\" {\n"
                            "TypeFlags: \"Light\"\n"
                            "Properties70:  {\n"
                            "P: \"LightType\", \"enum\", \"\", \"\",2\n"
                            "P: \"Color\", \"Color\", \"\", \"A\",1,1,1\n"
                            "P: \"Intensity\", \"Number\", \"\", \"A\",200\n"
                            "P: \"InnerAngle\", \"Number\", \"\", \"A\",30\n"
                            "P: \"OuterAngle\", \"Number\", \"\", \"A\",60\n"
                            "}\n"
                            "}\n"
                            "Model: 700, \"Model::lamp\", \"Light\" {\n"
                            "Version: 232\n"
                            "}\n"
                            "}\n"
                            "Connections:  {\n"
                            "C: \"OO\",200,0\n"
                            "C: \"OO\",100,200\n"
                            "C: \"OO\",400,0\n"
                            "C: \"OO\",300,400\n"
                            "C: \"OO\",500,200\n"
                            "C: \"OO\",700,0\n"
                            "C: \"OO\",600,700\n"
                            "}\n";

TEST_WITHIN( test_fbx_arrives, convert_enter, convert_leave )
{
    convert_write( "f.fbx", s_fbx );
    const CliResult* run = cli_run( "$R convert f.fbx f.glb" );
    assert_int_equal( run->status, 0 );
    assert_non_null( strstr( run->err, "camera 'cam': its field of view is taken as 60 degrees across" ) );
    {
        AUTO_SCENE upright = convert_load( "f.glb" ); // its z is up
        convert_assert_point( &upright.bounds_min.x, 1, 3, -3 );
        convert_assert_point( &upright.bounds_max.x, 2, 3, -2 );
        convert_assert_point( &upright.punctuals->direction.x, 0, 0, 1 );
    }
    cli_expect( cli_run( "$R convert f.fbx z.glb --quiet --up z" ), 0, NULL );
    AUTO_SCENE turned = convert_load( "z.glb" );
    convert_assert_point( &turned.bounds_min.x, 1, 3, -3 );
    cli_expect( cli_run( "$R convert f.fbx f.glb --quiet --overwrite --up y" ), 0, NULL );
    AUTO_SCENE scene = convert_load( "f.glb" );
    convert_assert_point( &scene.bounds_min.x, 1, 2, 3 ); // metres
    convert_assert_point( &scene.bounds_max.x, 2, 3, 3 );
    const RfMaterial* m = material_of( &scene, "m" );
    assert_true( convert_near( m->emission.x, 4 ) && convert_near( m->emission.y, 2 ) && convert_near( m->emission.z, 1 ) );
    RfMat4 eye = world_of( &scene, scene.cameras->node );
    assert_true( convert_near( eye.m[12], 0 ) && convert_near( eye.m[13], 0 ) && convert_near( eye.m[14], 5 ) );
    assert_true( convert_near( eye.m[10], 1 ) && convert_near( eye.m[5], 1 ) ); // +x of an FBX camera, turned by 90 degrees: −z
    assert_true( convert_near( scene.cameras->yfov, 2 * atan( tan( 0.5235987755982988 ) / 2 ) ) );
    assert_int_equal( scene.punctual_count, 1 );
    convert_assert_point( &scene.punctuals->direction.x, 0, -1, 0 );
    assert_true( convert_near( scene.punctuals->cos_outer, cos( 0.5235987755982988 ) ) );
}

TEST_WITHIN( test_hidden_objects_are_left_out, convert_enter, convert_leave )
{
    static const char place[] = "P: \"Lcl Translation\", \"Lcl Translation\", \"\", \"A\",100,200,300\n";
    static const char hidden[] = "P: \"Visibility\", \"Visibility\", \"\", \"A\",0";
    char* text = strdup( s_fbx );
    char* found = strstr( text, place );
    assert_non_null( found );
    memset( found, ' ', strlen( place ) - 1 );
    memcpy( found, hidden, strlen( hidden ) );
    convert_write( "h.fbx", text );
    free( text );
    const CliResult* run = cli_run( "$R convert h.fbx h.glb" );
    assert_int_equal( run->status, 1 );
    assert_non_null( strstr( run->err, "1 objects are hidden in the file: they are left out, as 'tri'" ) );
    assert_non_null( strstr( run->err, "has no triangles" ) );
}

// A U, and its area.
TEST_WITHIN( test_concave_faces_arrive_whole, convert_enter, convert_leave )
{
    convert_write( "u.obj", "v 0 0 0\nv 3 0 0\nv 3 3 0\nv 2 3 0\nv 2 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\nf 1 2 3 4 5 6 7 8\n" );
    cli_expect( cli_run( "$R convert u.obj u.glb --quiet" ), 0, NULL );
    AUTO_SCENE scene = convert_load( "u.glb" );
    double sum = 0.0, twice;
    assert_int_equal( scene.triangles.count, 6 );
    for ( uint32_t i = 0; i < 6; ++i )
    {
        RfVec3 a = rf_corner( &scene.triangles, i, 0 ), b = rf_corner( &scene.triangles, i, 1 ),
               c = rf_corner( &scene.triangles, i, 2 );
        rf_unit_cross( rf_sub( b, a ), rf_sub( c, a ), &twice );
        sum += 0.5 * twice;
    }
    assert_true( convert_near( sum, 7.0 ) );
}

TEST_WITHIN( test_missing_texture, convert_enter, convert_leave )
{
    convert_write( "a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n" );
    convert_write( "a.mtl", "newmtl m\nKd 1 1 1\nmap_Kd gone\\wall.png\n" );
    cli_expect( cli_run( "$R convert a.obj a.glb" ), 1,
                "a.obj: texture 'gone/wall.png': cannot be read, put it beside the file; --accept-losses goes on without" );
    assert_false( cli_exists( "a.glb" ) );
    cli_expect( cli_run( "$R convert a.obj a.glb --accept-losses" ), 0,
                "warning: texture 'gone/wall.png': cannot be read, put it beside the file: it is left out" );
    convert_write( "wall.png", "no picture" );
    convert_write( "a.mtl", "newmtl m\nKd 1 1 1\nmap_Kd gone\\wall.png\nmap_Ke lamp.png\n" );
    cli_expect( cli_run( "$R convert a.obj a.glb --overwrite" ), 1,
                "'gone/wall.png': is neither PNG nor JPEG, convert it and rename it; texture 'lamp.png': cannot be read" );
    const char* json = cli_run( "$R convert a.obj a.glb --overwrite --accept-losses --quiet --json -" )->out;
    assert_non_null( strstr( json, "\"losses\": [" ) );
    assert_non_null( strstr( json, "\"warnings\": 2" ) );
}

TEST_WITHIN( test_vertex_colours_arrive, convert_enter, convert_leave )
{
    convert_write( "a.obj", "v 0 0 0 1 0.5 0\nv 1 0 0 1 0.5 0\nv 0 1 0 1 0.5 0\nf 1 2 3\n" );
    cli_expect( cli_run( "$R convert a.obj a.glb --quiet" ), 0, NULL );
    AUTO_SCENE scene = convert_load( "a.glb" );
    assert_non_null( scene.triangles.colors );
    convert_assert_point( scene.triangles.colors, 1, 0.214041, 0 );               // linear
    assert_true( convert_near( scene.materials->textured->factors.base[0], 1 ) ); // and not darkened by assimp's grey
}

// An FBX file of two figures whose bones have one name: a square of which the upper half hangs on a bone at its middle, and a
// square three metres to the right with a shape that moves its upper side up by two, half of it before it is animated.
#define FBX_FIGURE( id, x )                                                                                                      \
    "Geometry: " id "1, \"Geometry::m\", \"Mesh\" {\nVertices: *12 {\na: 0,0,0,1,0,0,1,2,0,0,2,0\n}\n"                           \
    "PolygonVertexIndex: *4 {\na: 0,1,2,-4\n}\n}\n"                                                                              \
    "Model: " id "2, \"Model::square" id "\", \"Mesh\" {\nProperties70: {\n"                                                     \
    "P: \"Lcl Translation\", \"Lcl Translation\", \"\", \"A\"," x ",0,0\n}\n}\n"                                                 \
    "Model: " id "3, \"Model::bone\", \"LimbNode\" {\nProperties70: {\n"                                                         \
    "P: \"Lcl Translation\", \"Lcl Translation\", \"\", \"A\"," x ",1,0\n}\n}\n"                                                 \
    "Deformer: " id "4, \"Deformer::s\", \"Skin\" {\n}\n"                                                                        \
    "Deformer: " id "5, \"SubDeformer::c\", \"Cluster\" {\nIndexes: *2 {\na: 2,3\n}\nWeights: *2 {\na: 1,1\n}\n"                 \
    "Transform: *16 {\na: 1,0,0,0,0,1,0,0,0,0,1,0,0,-1,0,1\n}\n"                                                                 \
    "TransformLink: *16 {\na: 1,0,0,0,0,1,0,0,0,0,1,0," x ",1,0,1\n}\n}\n"
#define FBX_FIGURE_LINKS( id )                                                                                                   \
    "C: \"OO\"," id "2,0\nC: \"OO\"," id "1," id "2\nC: \"OO\"," id "3,0\n"                                                      \
    "C: \"OO\"," id "4," id "1\nC: \"OO\"," id "5," id "4\nC: \"OO\"," id "3," id "5\n"
#define FBX_CURVE( id, from, to )                                                                                                \
    "AnimationCurve: " id ", \"AnimCurve::\", \"\" {\nKeyVer: 4008\nKeyTime: *2 {\na: 0,46186158000\n}\n"                        \
    "KeyValueFloat: *2 {\na: " from "," to "\n}\nKeyAttrFlags: *1 {\na: 24840\n}\n}\n"

static const char s_figures[] =
    "; FBX 7.4.0 project file\nFBXHeaderExtension: {\nFBXHeaderVersion: 1003\nFBXVersion: 7400\n}\n"
    "GlobalSettings: {\nVersion: 1000\nProperties70: {\nP: \"UnitScaleFactor\", \"double\", \"Number\", \"\",100\n}\n}\n"
    "Objects: {\n" FBX_FIGURE( "1", "0" ) FBX_FIGURE(
        "2", "3" ) "Deformer: 30, \"Deformer::b\", \"BlendShape\" {\n}\n"
                   "Deformer: 31, \"SubDeformer::tall\", \"BlendShapeChannel\" {\nDeformPercent: 50\n}\n"
                   "Geometry: 32, \"Geometry::tall\", \"Shape\" {\nIndexes: *2 {\na: 2,3\n}\nVertices: *6 {\na: 0,2,0,0,2,0\n}\n"
                   "Normals: *6 {\na: 0,0,0,0,0,0\n}\n}\n"
                   "AnimationStack: 50, \"AnimStack::take\", \"\" {\n}\nAnimationLayer: 51, \"AnimLayer::base\", \"\" {\n}\n"
                   "AnimationCurveNode: 52, \"AnimCurveNode::R\", \"\" {\n}\n" FBX_CURVE(
                       "53", "0",
                       "90" ) "%s}\n" // animation of the shape
                              "Connections: {\n" FBX_FIGURE_LINKS( "1" ) FBX_FIGURE_LINKS(
                                  "2" ) "C: \"OO\",30,21\nC: \"OO\",31,30\nC: \"OO\",32,31\nC: \"OO\",51,50\nC: \"OO\",52,51\n"
                                        "C: \"OP\",52,13, \"Lcl Rotation\"\nC: \"OP\",53,52, \"d|Z\"\n%s}\n";

// That the box of all shapes is this at a time.
static void assert_box( const RfScene* scene, double time, const double want[6] )
{
    AUTO_POSE pose = gltf_pose_at( scene, time );
    double box[6] = { 1e9, 1e9, 1e9, -1e9, -1e9, -1e9 };
    for ( int i = -1; i < pose.scene.placement_count; ++i ) // −1: what stands still
    {
        const RfPlacement* placement = pose.scene.placements + i;
        const RfTriangles* t = i < 0 ? &pose.scene.triangles : &pose.scene.meshes[placement->mesh].triangles;
        const RfMat4 same = rf_mat4_identity();
        for ( uint32_t v = 0; v < 3 * t->count; ++v )
        {
            const float* p = t->positions + 3 * (size_t)t->indices[v];
            double local[3] = { (double)p[0], (double)p[1], (double)p[2] }, at[3];
            rf_mat4_apply( i < 0 ? &same : &placement->matrix, local, 1.0, at );
            for ( int k = 0; k < 3; ++k )
            {
                box[k] = fmin( box[k], at[k] );
                box[3 + k] = fmax( box[3 + k], at[k] );
            }
        }
    }
    for ( int k = 0; k < 6; ++k )
    {
        if ( fabs( box[k] - want[k] ) > 1e-4 )
            fail_msg( "at %g s number %d of the box is %g, not %g", time, k, box[k], want[k] );
    }
}

TEST_WITHIN( test_fbx_figures_move, convert_enter, convert_leave )
{
    char text[16384];
    snprintf( text, sizeof text, s_figures, "", "" );
    convert_write( "f.fbx", text );
    const CliResult* run = cli_run( "$R convert f.fbx f.glb" );
    cli_expect( run, 0, NULL );
    assert_non_null( strstr( run->out, "2 skins, 1 morph targets, 1 animations" ) );
    assert_non_null( strstr( run->err, "1 curves of animations are cubic or stepped" ) );
    RfScene scene = convert_load( "f.glb" );
    assert_box( &scene, 0.0, ( const double[] ){ 0, 0, 0, 4, 3, 0 } );
    assert_box( &scene, 1.0, ( const double[] ){ -1, 0, 0, 4, 3, 0 } ); // only the bone of the left one turns
    rf_destroy_scene( &scene );
    snprintf( text, sizeof text, s_figures,
              "AnimationCurveNode: 62, \"AnimCurveNode::DeformPercent\", \"\" {\n}\n" FBX_CURVE( "63", "0", "100" ),
              "C: \"OO\",62,51\nC: \"OP\",62,31, \"DeformPercent\"\nC: \"OP\",63,62, \"d|DeformPercent\"\n" );
    convert_write( "g.fbx", text );
    cli_expect( cli_run( "$R convert g.fbx g.glb --quiet" ), 0, NULL );
    scene = convert_load( "g.glb" );
    assert_box( &scene, 0.0, ( const double[] ){ 0, 0, 0, 4, 2, 0 } );
    assert_box( &scene, 1.0, ( const double[] ){ -1, 0, 0, 4, 4, 0 } );
    rf_destroy_scene( &scene );
}

// clang-format off
#define SQUARE( id, top )                                                                                                        \
    "<geometry id='" id "' name='" id "'><mesh><source id='" id "p'><float_array id='" id "a' count='12'>"                       \
    "0 0 0 1 0 0 1 " top " 0 0 " top " 0</float_array><technique_common><accessor source='#" id "a' count='4' stride='3'>"       \
    "<param name='X' type='float'/><param name='Y' type='float'/><param name='Z' type='float'/></accessor>"                      \
    "</technique_common></source><vertices id='" id "v'><input semantic='POSITION' source='#" id "p'/></vertices>"               \
    "<triangles count='2'><input semantic='VERTEX' source='#" id "v' offset='0'/><p>0 1 2 0 2 3</p></triangles>"                 \
    "</mesh></geometry>"
#define SOURCE( id, kind, count, values, stride, type )                                                                          \
    "<source id='" id "'><" kind " id='" id "a' count='" count "'>" values "</" kind "><technique_common>"                       \
    "<accessor source='#" id "a' count='1' stride='" stride "'><param type='" type "'/></accessor></technique_common></source>"
#define KEYS( id, times, values, target )                                                                                        \
    "<animation id='" id "'><source id='" id "t'><float_array id='" id "ta' count='2'>" times "</float_array><technique_common>" \
    "<accessor source='#" id "ta' count='2' stride='1'><param type='float'/></accessor></technique_common></source>"             \
    "<source id='" id "v'><float_array id='" id "va' count='2'>" values "</float_array><technique_common>"                       \
    "<accessor source='#" id "va' count='2' stride='1'><param type='float'/></accessor></technique_common></source>"             \
    "<sampler id='" id "s'><input semantic='INPUT' source='#" id "t'/><input semantic='OUTPUT' source='#" id "v'/></sampler>"    \
    "<channel source='#" id "s' target='" target "'/></animation>"

// A skin over morph targets, whose joint has the name of one of another skeleton, and turns.
static const char s_skin_over_morph[] =
    "<?xml version='1.0'?><COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>"
    "<asset><up_axis>Y_UP</up_axis></asset><library_geometries>%s%s</library_geometries><library_controllers>"
    "<controller id='m'><morph source='#low' method='NORMALIZED'>"
    SOURCE( "mt", "IDREF_array", "1", "high", "1", "IDREF" )
    SOURCE( "mw", "float_array", "1", "0.5", "1", "float" )
    "<targets><input semantic='MORPH_TARGET' source='#mt'/><input semantic='MORPH_WEIGHT' source='#mw'/></targets>"
    "</morph></controller><controller id='s'><skin source='#m'>"
    "<bind_shape_matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</bind_shape_matrix>"
    SOURCE( "sj", "Name_array", "1", "hip", "1", "name" )
    SOURCE( "sb", "float_array", "16", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1", "16", "float4x4" )
    SOURCE( "sw", "float_array", "1", "1", "1", "float" )
    "<joints><input semantic='JOINT' source='#sj'/><input semantic='INV_BIND_MATRIX' source='#sb'/></joints>"
    "<vertex_weights count='4'><input semantic='JOINT' source='#sj' offset='0'/>"
    "<input semantic='WEIGHT' source='#sw' offset='1'/><vcount>1 1 1 1</vcount><v>0 0 0 0 0 0 0 0</v></vertex_weights>"
    "</skin></controller></library_controllers><library_animations>"
    KEYS( "a", "0 1", "0 90", "b_hip/turn.ANGLE" )
    KEYS( "w", "0 2", "0.5 1", "mw(0)" )
    "</library_animations><library_visual_scenes><visual_scene id='v'>"
    "<node id='a_hip' sid='hip' type='JOINT'><translate>0 0 7</translate></node>"
    "<node id='b_hip' sid='hip' type='JOINT'><rotate sid='turn'>0 0 1 0</rotate></node>"
    "<node id='n'><instance_controller url='#s'><skeleton>#b_hip</skeleton></instance_controller></node>"
    "</visual_scene></library_visual_scenes><scene><instance_visual_scene url='#v'/></scene></COLLADA>";
// clang-format on

TEST_WITHIN( test_collada_figure_moves, convert_enter, convert_leave )
{
    char text[8192];
    snprintf( text, sizeof text, s_skin_over_morph, SQUARE( "low", "2" ), SQUARE( "high", "4" ) );
    convert_write( "c.dae", text );
    cli_expect( cli_run( "$R convert c.dae c.glb --quiet" ), 0, NULL );
    AUTO_SCENE scene = convert_load( "c.glb" );
    assert_box( &scene, 0.0, ( const double[] ){ 0, 0, 0, 1, 3, 0 } );
    assert_box( &scene, 1.0, ( const double[] ){ -3.5, 0, 0, 0, 1, 0 } );
}

// assimp has positions as floats: at 5400 km they are half a metre apart.
TEST_WITHIN( test_far_places_keep_their_digits, convert_enter, convert_leave )
{
    convert_write( "a.obj", "v 500000.125 5400000.25 100\nv 500000.25 5400000.25 100\nv 500000.25 5400000.5 100.125\nf 1 2 3\n" );
    const CliResult* run = cli_run( "$R convert a.obj a.glb --quiet && $R info a.glb" );
    cli_expect( run, 0, NULL );
    assert_null( strstr( run->err, "without area" ) );
    AUTO_SCENE scene = convert_load( "a.glb" );
    assert_int_equal( scene.triangles.count, 1 );
    double low = (double)scene.bounds_min.x + scene.origin[0], size = (double)( scene.bounds_max.y - scene.bounds_min.y );
    assert_true( low == 500000.125 && size == 0.25 );
    convert_write( "c.dae", COLLADA( "perspective", "<yfov>40</yfov>", "8e6 0 0 8000000.25 0 0 8e6 0 0.25" ) );
    cli_expect( cli_run( "$R convert c.dae c.glb --quiet" ), 0, NULL );
    size_t length;
    AUTO_FREE char* bytes = cli_read( "c.glb", &length );
    assert_non_null( strstr( bytes + 20, "\"min\":[0.0,0.0,0.0],\"max\":[0.25,0.0,0.25]" ) );
    assert_non_null( strstr( bytes + 20, "8000000.0,0.0,0.0,1.0],\"mesh\":0" ) );
}

TEST_WITHIN( test_texture_options_arrive, convert_enter, convert_leave )
{
    convert_write_obj();
    convert_write( "b.obj", "mtllib b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n" );
    convert_write( "b.mtl", "newmtl m\nmap_Kd -s 2 4 1 -o 0.5 0.25 0 -clamp on -mm 0 2 wall.png\n" );
    cli_expect( cli_run( "$R convert b.obj b.glb" ), 0, "material 'm': the option -mm of its texture is left out" );
    size_t size;
    AUTO_FREE char* bytes = cli_read( "b.glb", &size );
    const char* json = bytes + 20;
    assert_non_null( strstr( json, "\"KHR_texture_transform\":{\"offset\":[0.5,-3.25],\"scale\":[2.0,4.0]}" ) );
    assert_non_null( strstr( json, "\"samplers\":[{\"wrapS\":33071,\"wrapT\":33071}]" ) );
}
