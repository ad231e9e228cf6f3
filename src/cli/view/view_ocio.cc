// The only source that includes OpenColorIO. No exception leaves it.
#include "cli/view/view_ocio.h"

#include <OpenColorIO/OpenColorIO.h>

#include <cstdio>
#include <exception>
#include <string>
#include <strings.h>

namespace ocio = OCIO_NAMESPACE;

struct RfOcioView
{
    ocio::ConstCPUProcessorRcPtr processor;
};

namespace
{

bool same( const std::string& a, const std::string& b ) { return strcasecmp( a.c_str(), b.c_str() ) == 0; }

// The display whose name begins with sRGB, else the default one.
std::string find_display( const ocio::ConstConfigRcPtr& config )
{
    for ( int i = 0; i < config->getNumDisplays(); ++i )
    {
        if ( strncasecmp( config->getDisplay( i ), "sRGB", 4 ) == 0 )
            return config->getDisplay( i );
    }
    return config->getDefaultDisplay();
}

void add_name( std::string& list, const char* name ) { list += ( list.empty() ? "" : ", " ) + std::string( name ); }

bool find_view( const ocio::ConstConfigRcPtr& config, const std::string& display, std::string& view, std::string& names )
{
    for ( int i = 0; i < config->getNumViews( display.c_str() ); ++i )
    {
        const char* name = config->getView( display.c_str(), i );
        if ( same( name, view ) )
        {
            view = name;
            return true;
        }
        add_name( names, name );
    }
    return false;
}

// "Punchy" is "AgX - Punchy" of the view AgX; "High Contrast" is that of Filmic, unless the view has one of its own.
bool find_look( const ocio::ConstConfigRcPtr& config, const std::string& view, std::string& look, std::string& names )
{
    for ( const std::string& wanted : { view + " - " + look, look } )
    {
        names.clear();
        for ( int i = 0; i < config->getNumLooks(); ++i )
        {
            const char* name = config->getLookNameByIndex( i );
            if ( same( name, wanted ) )
            {
                look = name;
                return true;
            }
            add_name( names, name );
        }
    }
    return false;
}

RfOcioResult open( const char* path, std::string view, std::string look, RfOcioView* out, std::string& message )
{
    ocio::ConstConfigRcPtr config = ocio::Config::CreateFromFile( path );
    std::string display = find_display( config );
    if ( !find_view( config, display, view, message ) )
        return RF_OCIO_NO_VIEW;
    message.clear();
    if ( !look.empty() && !find_look( config, view, look, message ) )
        return RF_OCIO_NO_LOOK;
    ocio::DisplayViewTransformRcPtr transform = ocio::DisplayViewTransform::Create();
    transform->setSrc( ocio::ROLE_SCENE_LINEAR );
    transform->setDisplay( display.c_str() );
    transform->setView( view.c_str() );
    ocio::LegacyViewingPipelineRcPtr pipeline = ocio::LegacyViewingPipeline::Create();
    pipeline->setDisplayViewTransform( transform );
    if ( !look.empty() )
    {
        pipeline->setLooksOverrideEnabled( true );
        pipeline->setLooksOverride( look.c_str() );
    }
    out->processor = pipeline->getProcessor( config )->getDefaultCPUProcessor();
    return RF_OCIO_OK;
}

} // namespace

RfOcioResult rf_ocio_open( const char* config, const char* view, const char* look, RfOcioView** out, char* message, size_t size )
{
    *out = nullptr;
    RfOcioResult result = RF_OCIO_FAILED;
    try
    {
        ocio::SetLoggingLevel( ocio::LOGGING_LEVEL_NONE );
        RfOcioView* opened = new RfOcioView;
        std::string words;
        try
        {
            result = open( config, view, look, opened, words );
        }
        catch ( const std::exception& e )
        {
            words = e.what();
        }
        snprintf( message, size, "%s", words.c_str() );
        if ( result == RF_OCIO_OK )
            *out = opened;
        else
            delete opened;
    }
    catch ( ... )
    {
        snprintf( message, size, "out of memory" );
        result = RF_OCIO_FAILED;
    }
    return result;
}

void rf_ocio_close( RfOcioView* view ) { delete view; }

void rf_ocio_apply( const RfOcioView* view, float* rgb, int count )
{
    try
    {
        ocio::PackedImageDesc pixels( rgb, count, 1, 3 );
        view->processor->apply( pixels );
    }
    catch ( ... )
    {
        // of pixels that lie as they do here, nothing throws
    }
}
