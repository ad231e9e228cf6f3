#define _GNU_SOURCE // RTLD_NEXT
#include "support/embree_kind.h"

#include <dlfcn.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

static const char* s_instruction_set;

void use_embree_for( const char* instruction_set ) { s_instruction_set = instruction_set; }

// In the place of Embree's, which it calls.
void* rtcNewDevice( const char* configuration );

void* rtcNewDevice( const char* configuration )
{
    void* ( *create )( const char* );
    void* found = dlsym( RTLD_NEXT, "rtcNewDevice" );
    memcpy( &create, &found, sizeof create );
    char asked[128];
    const char* isa = s_instruction_set;
    snprintf( asked, sizeof asked, "%s%s%s", configuration, isa != NULL ? ",isa=" : "", isa != NULL ? isa : "" );
    return create( asked );
}
