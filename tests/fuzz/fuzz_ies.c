// Intensity profiles of lamps: what is read has a mean and densities.
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
        float u[2] = { 0.125f * (float)i, 0.999f - 0.125f * (float)i };
        RfVec3 d = rf_sample_profile( profile, u );
        float pdf = rf_profile_pdf_solid_angle( profile, d );
        fuzz_must( rf_profile_value( profile, d ) >= 0.0f && pdf >= 0.0f && isfinite( pdf ) );
    }
    rf_release_profile( profile );
    return 0;
}
