// PLY meshes of `convert`, and what is written of them.
#include "convert/model.h"
#include "fuzz/fuzz.h"

int LLVMFuzzerTestOneInput( const uint8_t* data, size_t size )
{
    RfError error = { 0 };
    RfModel model;
    RfLog log = { 0 };
    fuzz_check( rf_read_ply( fuzz_file( "input.ply", data, size ), &model, &log, &error ), &error );
    rf_destroy_model( &model );
    return 0;
}
