"""Names that a robot file may hold to break a page, and a robot that is called so from base to tip."""

import html
from pathlib import Path

NAMES = {
    "script": "<script>window.RAN=1</script>",
    "attribute": "\" onload=window.RAN=1 onmouseover='window.RAN=1' x=\"",
    "style": "</style></title><img src=x onerror=window.RAN=1>",
    "cdata": "]]><svg onload=window.RAN=1><!-- -->",
    "entities": "&lt;script&gt;&amp;#60;b&#x3c;'\"&",
    "bidi": "\u202etxt.live\u202c\u2066a\u2069",
    "lines": "a\nb\tc <iframe src=https://evil.example></iframe>",
    "long": "W" * 4_000,  # readers take no more than 4,096
    "latex": r"}\text{<b>}\href{javascript:window.RAN=1}{x}$\sqrt{",
}


def robot_called(name, folder: Path) -> Path:
    """A URDF of an arm with two joints whose every name begins so."""
    safe = html.escape(name).replace("\n", "&#10;").replace("\t", "&#9;")
    inertia = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    limit = '<limit lower="-1" upper="1" velocity="1" effort="0.5"/>'
    text = f"""<robot name="{safe}">
  <link name="{safe}0"/><link name="{safe}1">{inertia}</link><link name="{safe}2">{inertia}</link><link name="{safe}3"/>
  <joint name="{safe}1" type="revolute"><parent link="{safe}0"/><child link="{safe}1"/><axis xyz="0 0 1"/>{limit}</joint>
  <joint name="{safe}2" type="revolute"><parent link="{safe}1"/><child link="{safe}2"/>
    <origin xyz="1 0 0" rpy="0.3 0 0"/><axis xyz="0 1 0"/>{limit}</joint>
  <joint name="{safe}3" type="fixed"><parent link="{safe}2"/><child link="{safe}3"/><origin xyz="1 0 0"/></joint>
</robot>"""
    file = folder / "hostile.urdf"
    file.write_text(text, encoding="utf-8")
    return file
