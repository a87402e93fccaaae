"""A house as IFC4: storeys with spaces, walls with their openings, doors, windows, stairs.

Lengths are metres. IFC's z is up: (x, y, z) of the house becomes (x, -z, y). Bodies are extruded
areas, so that other programs can edit them. The writer is ifcopenshell (the extra `exports`).
"""

from __future__ import annotations

import uuid
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from plan2scene.house import House, Level, Stairs, SurfaceKey
from plan2scene.io import atomic_path
from plan2scene.mesh.assembly import Storey, assemble
from plan2scene.mesh.joinery import JOINERY
from plan2scene.mesh.polygons import polygons_of
from plan2scene.mesh.stairs import step_areas
from plan2scene.mesh.structure import open_plate
from plan2scene.mesh.texture_files import TileTexture
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.wall_sides import Portal
from plan2scene_app.exports.solids import SLAB, footprint, middle_strip, wall_area

#: Namespace of all ids: they derive from the house's id and names, so a house always gives the same
#: file.
_NAMESPACE = uuid.UUID("6f2a2f0e-7a52-4b7c-9f2b-6d1d6c0f3a11")
_EPOCH = "1970-01-01T00:00:00"


def write_ifc(house: House, textures: Mapping[SurfaceKey, TileTexture], folder: Path) -> None:
    """Write ``house.ifc`` of a house into a folder; textures are not used."""
    import ifcopenshell
    import ifcopenshell.guid

    del textures
    model = _Model(house, ifcopenshell).build()
    with atomic_path(folder / "house.ifc") as temporary:
        temporary.write_text(model.to_string(), encoding="utf-8")


class _Model:
    """Builds the IFC model of a house."""

    def __init__(self, house: House, ifcopenshell: Any) -> None:
        self.house, self._ifc = house, ifcopenshell
        self.file = ifcopenshell.file(schema="IFC4")

    def build(self) -> Any:
        """Return the model."""
        header = self.file.header
        header.file_name.time_stamp = _EPOCH
        header.file_name.name = f"{self.house.id}.ifc"
        building = self._building()
        storeys = assemble(self.house).storeys
        entities = [self._storey(storey.level, building) for storey in storeys]
        self._relate(
            "IfcRelAggregates",
            "storey 0 of IfcBuilding",
            RelatingObject=building,
            RelatedObjects=entities,
        )
        for storey, entity in zip(storeys, entities, strict=True):
            self._fill(storey, entity)
        return self.file

    def _storey(self, level: Level, building: Any) -> Any:
        """Return an empty storey."""
        return self._root(
            "IfcBuildingStorey",
            level.id or "storey 0",
            LongName=level.name or None,
            ObjectPlacement=self._placement(building.ObjectPlacement, level.elevation),
            CompositionType="ELEMENT",
            Elevation=level.elevation,
        )

    def _fill(self, storey: Storey, here: Any) -> None:
        """Add the contents of a storey."""
        level = storey.level
        own = f" of {level.id}" if level.id else ""
        self._place = here.ObjectPlacement
        self._spaces(storey, here, own)
        elements = []
        for body in storey.bodies:
            wall = body.side.wall
            through = [p for p in storey.portals if footprint(p).intersects(wall_area(body))]
            elements += self._wall(wall.id, wall_area(body), wall.height, through)
        elements += [self._stairs(s) for s in self.house.stairs if s.level == level.id]
        self._relate(
            "IfcRelContainedInSpatialStructure",
            f"contents{own}",
            RelatedElements=elements,
            RelatingStructure=here,
        )

    def _stairs(self, stairs: Stairs) -> Any:
        """Return a flight of stairs with an extrusion for each step."""
        rise = self.house.rise_of(stairs)
        return self._root(
            "IfcStair",
            stairs.id,
            ObjectPlacement=self._placement(self._place),
            Representation=self._represented(
                [
                    solid
                    for area, low, high in step_areas(stairs, rise)
                    for solid in self._extruded(area, low, high)
                ]
            ),
            PredefinedType="STRAIGHT_RUN_STAIR",
        )

    def _root(self, kind: str, name: str, **facts: Any) -> Any:
        """Return a new rooted entity with an id derived from its kind and name."""
        entity_id = uuid.uuid5(_NAMESPACE, f"{self.house.id}/{kind}/{name}")
        guid = self._ifc.guid.compress(entity_id.hex)
        return self.file.create_entity(kind, GlobalId=guid, Name=name, **facts)

    def _relate(self, kind: str, name: str, **facts: Any) -> None:
        self._root(kind, name, **facts)

    def _point(self, *values: float) -> Any:
        return self.file.createIfcCartesianPoint([round(float(v), 6) + 0.0 for v in values])

    def _placement(self, relative: Any = None, y: float = 0.0) -> Any:
        axis = self.file.createIfcAxis2Placement3D(self._point(0, 0, y))
        return self.file.createIfcLocalPlacement(relative, axis)

    def _building(self) -> Any:
        """Add the project, the site and the building; return the building."""
        f = self.file
        units = [
            f.createIfcSIUnit(None, kind, None, name)
            for kind, name in (
                ("LENGTHUNIT", "METRE"),
                ("AREAUNIT", "SQUARE_METRE"),
                ("VOLUMEUNIT", "CUBIC_METRE"),
                ("PLANEANGLEUNIT", "RADIAN"),
            )
        ]
        origin = f.createIfcAxis2Placement3D(self._point(0, 0, 0))
        context = f.createIfcGeometricRepresentationContext(None, "Model", 3, 1e-5, origin, None)
        self._body = f.createIfcGeometricRepresentationSubContext(
            "Body", "Model", None, None, None, None, context, None, "MODEL_VIEW", None
        )
        project = self._root(
            "IfcProject",
            self.house.id,
            LongName=self.house.name or None,
            RepresentationContexts=[context],
            UnitsInContext=f.createIfcUnitAssignment(units),
        )
        above, place = project, None
        for kind, name in (("IfcSite", "site"), ("IfcBuilding", "building")):
            place = self._placement(place)
            here = self._root(kind, name, ObjectPlacement=place, CompositionType="ELEMENT")
            self._relate(
                "IfcRelAggregates",
                f"{name} of {above.is_a()}",
                RelatingObject=above,
                RelatedObjects=[here],
            )
            above = here
        return above

    def _spaces(self, storey: Storey, here: Any, own: str) -> None:
        """Add a space and a floor slab for each room; `own` names the storey's relations."""
        spaces, slabs = [], []
        for room in storey.house.rooms:
            polygon = room_polygon(room)
            floor = open_plate(polygon, "floor", storey.well, storey.above)
            spaces.append(
                self._root(
                    "IfcSpace",
                    room.id,
                    LongName=room.title,
                    ObjectPlacement=self._placement(self._place),
                    Representation=self._shape(polygon, 0.0, room.height),
                    CompositionType="ELEMENT",
                    PredefinedType="EXTERNAL" if room.open_air else "INTERNAL",
                )
            )
            if floor.is_empty:  # the whole floor is an opening for stairs
                continue
            slabs.append(
                self._root(
                    "IfcSlab",
                    f"{room.id}/floor",
                    ObjectPlacement=self._placement(self._place),
                    Representation=self._shape(floor, -SLAB, 0.0),
                    PredefinedType="FLOOR",
                )
            )
        self._relate("IfcRelAggregates", f"spaces{own}", RelatingObject=here, RelatedObjects=spaces)
        self._relate(
            "IfcRelContainedInSpatialStructure",
            f"floors{own}",
            RelatedElements=slabs,
            RelatingStructure=here,
        )

    def _wall(
        self, wall_id: str, area: BaseGeometry, height: float, through: list[Portal]
    ) -> list[Any]:
        """Add a wall with its openings, doors and windows; return the wall, doors and windows."""
        wall = self._root(
            "IfcWall",
            wall_id,
            ObjectPlacement=self._placement(self._place),
            Representation=self._shape(area, 0.0, height),
        )
        elements = [wall]
        for portal in through:
            hole, name = portal.hole, f"{wall_id}/{portal.hole.opening.id}"
            shape = self._shape(footprint(portal), hole.bottom, min(hole.top, height))
            opening = self._root(
                "IfcOpeningElement",
                name,
                ObjectPlacement=self._placement(wall.ObjectPlacement),
                Representation=shape,
                PredefinedType="OPENING",
            )
            self._relate(
                "IfcRelVoidsElement",
                name,
                RelatingBuildingElement=wall,
                RelatedOpeningElement=opening,
            )
            if hole.opening.kind == "passage" or portal.side.wall.id != wall_id:
                continue
            kind = "IfcDoor" if hole.opening.kind == "door" else "IfcWindow"
            leaf_area = Polygon(middle_strip(portal, 0.0, portal.width, JOINERY.leaf))
            leaf = self._root(
                kind,
                f"{portal.side.room_id}/{hole.opening.id}",
                ObjectPlacement=self._placement(opening.ObjectPlacement),
                Representation=self._shape(leaf_area, hole.bottom, hole.top),
                OverallHeight=hole.top - hole.bottom,
                OverallWidth=portal.width,
            )
            self._relate(
                "IfcRelFillsElement",
                name,
                RelatingOpeningElement=opening,
                RelatedBuildingElement=leaf,
            )
            elements.append(leaf)
        return elements

    def _shape(self, area: BaseGeometry, low: float, high: float) -> Any:
        """Return upright extrusions of a plan area from height `low` to `high`."""
        return self._represented(self._extruded(area, low, high))

    def _represented(self, solids: list[Any]) -> Any:
        """Return the product shape that consists of these solids."""
        shape = self.file.createIfcShapeRepresentation(self._body, "Body", "SweptSolid", solids)
        return self.file.createIfcProductDefinitionShape(None, None, [shape])

    def _extruded(self, area: BaseGeometry, low: float, high: float) -> list[Any]:
        """Return upright prisms over the polygons of a plan area."""
        f = self.file
        solids = []
        for polygon in polygons_of(area):
            outline = self._ring(polygon.exterior)
            if polygon.interiors:
                holes = [self._ring(ring) for ring in polygon.interiors]
                profile = f.createIfcArbitraryProfileDefWithVoids("AREA", None, outline, holes)
            else:
                profile = f.createIfcArbitraryClosedProfileDef("AREA", None, outline)
            position = f.createIfcAxis2Placement3D(self._point(0, 0, low))
            up = f.createIfcDirection([0.0, 0.0, 1.0])
            solids.append(f.createIfcExtrudedAreaSolid(profile, position, up, float(high - low)))
        return solids

    def _ring(self, ring: Any) -> Any:
        """Return a ring of plan points (x, z) as a closed polyline of (x, -z)."""
        points = [self._point(x, -z) for x, z in np.asarray(ring.coords)[:-1]]
        return self.file.createIfcPolyline([*points, points[0]])
