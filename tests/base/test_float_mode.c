// Subnormal inputs and results are zero where that is set, and numbers where not.
#include "base/float_mode.h"
#include "support/test.h"

#include <float.h>

TEST( test_subnormals_are_flushed_where_that_is_set )
{
    volatile float least = FLT_MIN, subnormal = 1e-40f, half = 0.5f, large = 0x1p20f; // read anew in each mode
    bool before = rf_flush_subnormals( false );
    assert_true( least * half > 0.0f && subnormal * large > 0.0f );
    assert_false( rf_flush_subnormals( true ) );
    volatile float result = least * half, of_input = subnormal * large;
    assert_true( rf_flush_subnormals( before ) );
    assert_true( result == 0.0f && of_input == 0.0f );
    assert_true( least * half > 0.0f || before );
}
