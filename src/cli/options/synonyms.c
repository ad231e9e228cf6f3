#include "cli/options/synonyms.h"

#include <stddef.h>
#include <string.h>

// Words of Blender, pbrt, Mitsuba, ffmpeg, Embree's tutorials and of Unix. Where a word has
// several meanings, each command takes the first that it has.
static const char* const s_synonyms[][2] = {
    { "samples", "spp" },
    { "samples-per-pixel", "spp" },
    { "resolution", "size" },
    { "dimensions", "size" },
    { "width", "size" },
    { "height", "size" },
    { "quality", "noise" },
    { "error", "noise" },
    { "noise-threshold", "noise" },
    { "seconds", "time" },
    { "seconds", "budget" },
    { "time-limit", "time" },
    { "time", "budget" },
    { "duration", "time" },
    { "framerate", "fps" },
    { "frame-rate", "fps" },
    { "rate", "fps" },
    { "range", "frames" },
    { "start", "frames" },
    { "end", "frames" },
    { "bounces", "max-depth" },
    { "max-bounces", "max-depth" },
    { "depth", "max-depth" },
    { "cores", "threads" },
    { "jobs", "threads" },
    { "cpus", "threads" },
    { "ram", "memory" },
    { "layers", "aov" },
    { "layers", "layer" },
    { "layer", "aov" },
    { "passes", "aov" },
    { "channel", "layer" },
    { "denoise-layers", "aov" },
    { "window", "group" },
    { "block", "tile" },
    { "bucket", "tile" },
    { "force", "overwrite" },
    { "replace", "overwrite" },
    { "continue", "resume" },
    { "silent", "quiet" },
    { "stops", "exposure" },
    { "ev", "exposure" },
    { "brightness", "exposure" },
    { "ground-truth", "reference" },
    { "units", "scale" },
    { "view", "camera" },
    // commands
    { "diff", "compare" },
    { "benchmark", "cost" },
    { "bench", "cost" },
    { "poisson", "reconstruct" },
    { "solve", "reconstruct" },
    { "view", "png" },
    { "export", "png" },
    { "import", "convert" },
    { "html", "report" },
    { "page", "report" },
    { "inspect", "info" },
    { "version", "--version" },
    { "man", "--man" },
    { "manual", "--man" },
};

const char* rf_find_synonym( const char* word, const char* const* words, int count )
{
    for ( size_t i = 0; i < sizeof s_synonyms / sizeof s_synonyms[0]; ++i )
    {
        for ( int k = 0; k < count && strcmp( s_synonyms[i][0], word ) == 0; ++k )
        {
            if ( strcmp( s_synonyms[i][1], words[k] ) == 0 )
                return words[k];
        }
    }
    return NULL;
}
