"""The settings of the render engine, their panels, and Cycles' panels that it shows as well."""
import re
import shlex
import sys

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from .programs import ENGINE, ExportSettings

TILES = (("1", "None", "Pixels share no paths"), *((n + "x" + n, n + " × " + n, "A block of pixels") for n in "234"),
         ("rooks16", "16 Rooks", "Pixels of which no two are in the same row or column"),
         ("auto", "Automatic", "The block of pixels that pays, by a short trial render"))  # last: files keep the number

# Of Cycles' panels for the whole render those whose settings are carried, of its others all but a few.
RENDER = re.compile(r"CYCLES_RENDER_PT_(motion_blur|film|film_transparency|simplify(_viewport|_render)?|passes(_crypto|_lightgroups)?)")
CYCLES_ALONE = re.compile(r"CYCLES_(RENDER_.*|PT_.*presets|PT_post_processing|VIEW3D_.*|.*_PT_preview|.*_PT_volume|WORLD_PT_mist"
                          r"|.*_PT_settings_volume|OBJECT_PT_shading_(gi_approximation|caustics)|OBJECT_PT_visibility_culling)")
BLENDER_ALONE = re.compile(r".*_PT_(freestyle|gpencil|grease_pencil|stereoscopy|opengl|eevee).*")


class ReframeSettings(bpy.types.PropertyGroup, ExportSettings):
    samples: IntProperty(name="Samples", min=0, soft_max=1024, default=0,
                         description="Samples traced per pixel and frame; paths reused from other frames and pixels come on top. "
                         "0: 28, or with Noise as many as it takes")
    noise: FloatProperty(name="Noise", min=0.0, soft_max=50.0, default=0.0, subtype="PERCENTAGE",
                         description="Render each frame until its estimated noise is at most this. 0: Samples alone decide")
    clamp: EnumProperty(name="Clamp", default="off", description="Limit the luminance that one indirect path brings, against white specks",
                        items=(("off", "Off", "Nothing is removed"), ("value", "Value", "The limit below"),
                               ("auto", "Automatic", "The limit of least error, which grows with the samples")))
    clamp_value: FloatProperty(name="Limit", min=0.001, soft_max=100.0, default=10.0,
                               description="Largest luminance that one indirect path brings to a pixel")
    is_group_auto: BoolProperty(name="Automatic Group", default=True, description="Choose the group by a short trial render")
    group: IntProperty(name="Group", min=0, max=16, default=2,
                       description="Share paths between 2N+1 neighbouring frames of an animation. 0: none. A frame alone (F12) shares none")
    tile: EnumProperty(name="Tile", default="auto", description="Pixels of a frame that share paths. Not used with Denoise", items=TILES)
    denoise: BoolProperty(name="Denoise", default=False, description="Denoise each frame by Open Image Denoise, and tell the error that is left")
    folder: StringProperty(name="Folder", subtype="DIR_PATH", default="//reframe",
                           description="Where the exported scene and the frames of an animation stay, so that a render which was stopped "
                           "goes on. //: beside the .blend")
    arguments: StringProperty(name="Options", description="More options of reframe render, such as --light-paths on --max-depth 8")

    def group_options(self):
        return ["--group", "auto" if self.is_group_auto else str(self.group)]

    def render_options(self):
        options = ["--denoise"] if self.denoise else ["--tile", self.tile]
        if self.samples > 0:
            options += ["--spp", str(self.samples)]
        if self.noise > 0.0:
            options += ["--noise", "%.6g%%" % self.noise]
        if self.clamp != "off":
            options += ["--clamp", "%.6g" % self.clamp_value if self.clamp == "value" else self.clamp]
        return options + shlex.split(self.arguments)


class EnginePanel:
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "render"
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES

    def draw(self, context):
        self.layout.use_property_split, self.layout.use_property_decorate = True, False
        self.draw_settings(self.layout, context.scene.reframe_render, context.scene.render)


class REFRAME_PT_sampling(EnginePanel, bpy.types.Panel):
    bl_label = "Sampling"

    def draw_settings(self, layout, settings, render):
        layout.prop(settings, "samples")
        layout.prop(settings, "noise")
        layout.prop(settings, "denoise")
        layout.prop(settings, "clamp")
        if settings.clamp == "value":
            layout.prop(settings, "clamp_value")


class REFRAME_PT_reuse(EnginePanel, bpy.types.Panel):
    bl_label = "Path Reuse"

    def draw_settings(self, layout, settings, render):
        layout.prop(settings, "is_group_auto")
        column = layout.column()
        column.active = not settings.is_group_auto
        column.prop(settings, "group")
        layout.prop(settings, "tile")


class REFRAME_PT_threads(EnginePanel, bpy.types.Panel):
    bl_label, bl_options = "Threads", {"DEFAULT_CLOSED"}

    def draw_settings(self, layout, settings, render):
        layout.prop(render, "threads_mode")
        column = layout.column()
        column.enabled = render.threads_mode == "FIXED"
        column.prop(render, "threads")


class REFRAME_PT_export(EnginePanel, bpy.types.Panel):
    bl_label = "Export"

    def draw_settings(self, layout, settings, render):
        for name in ("bake", "accept_losses", "folder", "arguments"):
            layout.prop(settings, name)


class REFRAME_PT_passes(EnginePanel, bpy.types.Panel):
    """Those that are rendered"""
    bl_label, bl_context = "Data and Light", "view_layer"

    def draw(self, context):
        layout, layer = self.layout, context.view_layer
        layout.use_property_split, layout.use_property_decorate = True, False
        column = layout.column(heading="Include", align=True)
        for name in ("z", "normal", "vector", "emit", "object_index", "material_index"):
            column.prop(layer, "use_pass_" + name)
        if hasattr(layer, "cycles"):
            column.prop(layer.cycles, "denoising_store_passes", text="Denoising Data")


CLASSES = (ReframeSettings, REFRAME_PT_sampling, REFRAME_PT_reuse, REFRAME_PT_threads, REFRAME_PT_export, REFRAME_PT_passes)


# Panels and nodes of Blender's own.


def panels(cls=bpy.types.Panel):
    for one in cls.__subclasses__():
        yield one
        yield from panels(one)


_before = []  # panels, names of their attributes, and what these were


def replace(panel, name, value):
    _before.append((panel, name, vars(panel).get(name)))
    setattr(panel, name, value)


def only_for_cycles(poll):
    return classmethod(lambda cls, context: context.engine == "CYCLES" and poll.__func__(cls, context))


def share_panels():
    """Panels have a set of engines, which most of Cycles' inherit: those that are not shared get one of their own. Some ask the class that
    they inherit from whether they are shown."""
    for panel in list(panels()):
        engines, name = getattr(panel, "COMPAT_ENGINES", ()), panel.__name__.removeprefix("NODE_")
        if "CYCLES" not in engines:
            continue
        if RENDER.fullmatch(name) or not (CYCLES_ALONE if name.startswith("CYCLES") else BLENDER_ALONE).fullmatch(name):
            engines.add(ENGINE)
        elif name.startswith("CYCLES"):
            replace(panel, "COMPAT_ENGINES", {"CYCLES"})
            if "poll" in vars(panel):
                replace(panel, "poll", only_for_cycles(vars(panel)["poll"]))


def leave_panels():
    while _before:
        panel, name, value = _before.pop()
        if value is None:
            delattr(panel, name)
        else:
            setattr(panel, name, value)
    for panel in list(panels()):
        if not panel.__name__.startswith("REFRAME"):
            getattr(panel, "COMPAT_ENGINES", set()).discard(ENGINE)


def is_cycles_or_ours(context):
    return context.engine in {"CYCLES", "REFRAME"}


_polls = []  # functions, and the code that they had


def share_nodes():
    """The menu Add of shader nodes asks these functions, of which others keep references: their code is replaced."""
    for module in ("nodeitems_builtins", "bl_ui.node_add_menu_shader"):
        poll = getattr(sys.modules.get(module), "cycles_shader_nodes_poll", None)
        if poll is not None:
            _polls.append((poll, poll.__code__))
            poll.__code__ = is_cycles_or_ours.__code__


def leave_nodes():
    while _polls:
        poll, code = _polls.pop()
        poll.__code__ = code


def register():
    if hasattr(bpy.types, "CYCLES_RENDER_PT_passes"):
        REFRAME_PT_passes.bl_parent_id = "CYCLES_RENDER_PT_passes"
    for one in CLASSES:
        bpy.utils.register_class(one)
    bpy.types.Scene.reframe_render = PointerProperty(type=ReframeSettings)
    share_panels()
    share_nodes()


def unregister():
    leave_nodes()
    leave_panels()
    del bpy.types.Scene.reframe_render
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
