"""Writes Blender's Principled Volume into USD files, which Blender by itself leaves out.

Run it in Blender before *File > Export > Universal Scene Description*: open it in the text editor and press
*Run*, or `blender shot.blend --python fogbow_usd_hook.py`. Each material with a Principled Volume gets a volume
shader whose inputs are named as those of the node, and is bound to the volumes that have it. fogbow reads them,
and so may others.
"""

import bpy
from pxr import Gf, Sdf, UsdShade

#: Inputs of the node, and what they are called in the file.
NUMBERS = {
    "Density": "density",
    "Anisotropy": "anisotropy",
    "Emission Strength": "emission",
    "Blackbody Intensity": "blackbody",
    "Temperature": "temperature",
}
COLOURS = {
    "Color": "color",
    "Absorption Color": "absorption_color",
    "Emission Color": "emission_color",
    "Blackbody Tint": "blackbody_tint",
}
FIELDS = {
    "Density Attribute": "density_attribute",
    "Color Attribute": "color_attribute",
    "Temperature Attribute": "temperature_attribute",
}


def principled(material):
    """The Principled Volume that is linked to the output of a material."""
    tree = material.node_tree if material else None
    output = tree.get_output_node("ALL") if tree else None
    links = output.inputs["Volume"].links if output else ()
    node = links[0].from_node if links else None
    return node if node and node.bl_idname == "ShaderNodeVolumePrincipled" else None


def write(stage, path, node):
    """The material at a path with the values of the node. What is linked to its inputs is not followed."""
    material = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, path.AppendChild("principled_volume"))
    shader.CreateIdAttr("BlenderPrincipledVolume")
    for name, given in NUMBERS.items():
        shader.CreateInput(given, Sdf.ValueTypeNames.Float).Set(node.inputs[name].default_value)
    for name, given in COLOURS.items():
        value = Gf.Vec3f(*node.inputs[name].default_value[:3])
        shader.CreateInput(given, Sdf.ValueTypeNames.Color3f).Set(value)
    for name, given in FIELDS.items():
        shader.CreateInput(given, Sdf.ValueTypeNames.String).Set(node.inputs[name].default_value)
    output = shader.CreateOutput("volume", Sdf.ValueTypeNames.Token)
    material.CreateVolumeOutput().ConnectToSource(output)
    return material


class FogbowVolumes(bpy.types.USDHook):
    """Adds the materials of volumes to an export."""

    bl_idname = "fogbow_volumes"
    bl_label = "Principled Volume for fogbow"

    @staticmethod
    def on_export(context):
        stage = context.get_stage()
        materials = {}
        for prim in list(stage.Traverse()):
            name = prim.GetParent().GetAttribute("userProperties:blender:object_name")
            shown = name.Get() if prim.GetTypeName() == "Volume" and name else None
            found = bpy.data.objects.get(shown) if shown else None
            material = found.active_material if found else None
            node = principled(material)
            if node is None:
                continue
            if material.name not in materials:
                stem = "".join(c if c.isalnum() else "_" for c in material.name)
                top = stage.GetDefaultPrim().GetPath()
                path = top.AppendChild("_volume_materials").AppendChild("v_" + stem)
                materials[material.name] = write(stage, path, node)
            UsdShade.MaterialBindingAPI.Apply(prim).Bind(materials[material.name])
        return True


def register():
    bpy.utils.register_class(FogbowVolumes)


if __name__ == "__main__":
    register()
