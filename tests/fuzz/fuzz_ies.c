// Intensity profiles of lamps: what is read has a mean and values.
#include "fuzz/fuzz.h"

#include "scene/profile.h"

#include <math.h>

int LLVMFuzzerTestOneInput( const uint8_t* data, size_t size )
{
    RfError error = { 0 };
    RfProfile* profile = NULL;
    RfResult result = rf_read_ies( "input.ies", data, size, &profile, &error );
    fuzz_check( result, &error );
    if ( result != RF_OK )
        return 0;
    fuzz_must( profile->mean >= 0.0 && isfinite( profile->mean ) );
    for ( int i = 0; i < 8; ++i )
    {
        float z = 0.25f * (float)i - 0.875f, s = sqrtf( 1.0f - z * z );
        float value = rf_profile_value( profile, rf_vec3( s * cosf( (float)i ), s * sinf( (float)i ), z ) );
        fuzz_must( value >= 0.0f && isfinite( value ) );
    }
    rf_release_profile( profile );
    return 0;
}
