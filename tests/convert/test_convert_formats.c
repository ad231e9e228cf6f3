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

#define COLLADA( optics )                                                                                                        \
    "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\">"                  \
    "<asset><unit name=\"half\" meter=\"0.5\"/><up_axis>Z_UP</up_axis></asset>"                                                  \
    "<library_cameras><camera id=\"eye\" name=\"eye\"><optics><technique_common><perspective>" optics                            \
    "<znear>0.1</znear><zfar>100</zfar></perspective></technique_common></optics></camera></library_cameras>"                    \
    "<library_lights><light id=\"spot\" name=\"spot\"><technique_common><spot><color>4 2 2</color>"                              \
    "<falloff_angle>60</falloff_angle></spot></technique_common></light></library_lights>"                                       \
    "<library_geometries><geometry id=\"g\" name=\"g\"><mesh><source id=\"p\">"                                                  \
    "<float_array id=\"pa\" count=\"9\">0 0 0 1 0 0 0 0 1</float_array><technique_common>"                                       \
    "<accessor source=\"#pa\" count=\"3\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/>"     \
    "<param name=\"Z\" type=\"float\"/></accessor></technique_common></source>"                                                  \
    "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices><triangles count=\"1\">"                          \
    "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>"     \
    "<library_visual_scenes><visual_scene id=\"s\">"                                                                             \
    "<node id=\"tri\" name=\"tri\"><translate>1 2 3</translate><instance_geometry url=\"#g\"/></node>"                           \
    "<node id=\"eye\" name=\"eye\"><translate>0 -5 1</translate><rotate>1 0 0 90</rotate><instance_camera url=\"#eye\"/></node>" \
    "<node id=\"lamp\" name=\"lamp\"><translate>0 0 4</translate><instance_light url=\"#spot\"/></node>"                         \
    "</visual_scene></library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>"

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
    convert_write( "c.dae", COLLADA( "<xfov>60</xfov><aspect_ratio>2</aspect_ratio>" ) );
    cli_expect( cli_run( "$R convert c.dae c.glb" ), 0, "candela or lux" );
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
    // of yfov with its aspect the angle is the file's own; what assimp computes wrongly is dropped
    convert_write( "d.dae", COLLADA( "<yfov>40</yfov><aspect_ratio>2</aspect_ratio>" ) );
    cli_expect( cli_run( "$R convert d.dae d.glb --quiet" ), 0, NULL );
    scene = convert_load( "d.glb" );
    assert_true( convert_near( scene.cameras->yfov, 40 * 3.14159265358979 / 180 ) );
    rf_destroy_scene( &scene );
    convert_write( "e.dae", COLLADA( "<xfov>60</xfov><yfov>40</yfov>" ) );
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
    assert_non_null( strstr( run->err, "its z points up: unless that is given already, convert it with z up" ) );
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
