import pytest

from plan2scene.plans.room_names import has_bare_floor, is_garage, room_types

NAMES = {
    ("Bedroom",): "Master bedroom 2|Zimmer 2|Camera da letto|Slaapkamer|Makuuhuone 2|Sypialnia"
    "|Yatak odası|חדר שינה|洋室6帖|BDRM 2|BR1|M.BED|Schlafz.|Dorm. 2|ALK|Eltern"
    '|Ložnice|Hálószoba|Spavaća soba|Szoba 2|침실 1|次卧|غرفة نوم|ΥΠΝΟΔΩΜΑΤΙΟ|Phòng ngủ 1|ממ"ד',
    ("Bathroom",): "Salle de bains|WC|Upstairs Bathroom|Baño|Garage / WC|Łazienka|Casa de banho"
    "|Banho|PWDR|PDR RM|ENS.|W.C.|KH|SdB|Gästebad"
    "|אמבטיה|Koupelna|Fürdőszoba|С/У|С/у 2|卫生间|욕실|Μπάνιο|Baie|SdE",
    ("Reception",): "Wohnzimmer|Séjour|Soggiorno|Woonkamer|LivingRoom|Гостиная|FAM RM|Sogg."
    "|Obývací pokoj|Nappali|Dnevni boravak|Dnevna soba|거실|餐厅|المعيشة|Σαλόνι|Phòng khách"
    "|Rec Room|Sala de jantar|Tinello|Жилая комната",
    ("Kitchen",): "Butler's pantry|BUTLERS PANTRY|KIT|K|Køkken|מטבח"
    "|Kuchyň|Konyha|주방|ΚΟΥΖΙΝΑ|Bucătărie|Nhà bếp",
    ("Closet",): "W/I CL|W/I A|Ripostiglio|ST|W.I.R.|WIC|P'TRY|CUPB'D|Abstellr."
    "|Šatna|Walk-in|Cabina armadio|衣帽间|Αποθήκη",
    ("Kitchen", "Reception"): "Küche/Essen",
    ("Reception", "Kitchen"): "Living / Kitchen",
    ("Balcony",): "BALCONY|PARV.|Erkély|Sacada|발코니|شرفة",
    ("Terrace",): "Teraza",
    ("Corridor",): "Przedpokój 2|Dist.|Circulação|Corr.",
    ("Entrance",): "玄関ホール|Vorzimmer|Előszoba|Předsíň|현관",
    ("Unknown",): "HWR|L'DRY|L’DRY|LDRY|L.DRY|LNDRY|GAR.|Постирочная|Tendedero|Arbeiten",
    (): "Фасад||Zone 51|Baie vitrée",
}


@pytest.mark.parametrize("types", NAMES)
def test_names(types):
    names = NAMES[types].split("|")
    assert {name: room_types(name) for name in names} == dict.fromkeys(names, types)


@pytest.mark.parametrize(
    ("name", "garage"),
    [("Double Garage", True), ("GARAJE", True), ("Garage / WC", False), ("Garden", False)],
)
def test_a_garage_is_told_by_its_name(name, garage):
    assert is_garage(name) is garage


@pytest.mark.parametrize(
    ("name", "types", "bare"),
    [
        ("Kök", ("Kitchen",), True),
        ("L'DRY", ("Unknown",), True),
        ("Bijkeuken", ("Unknown",), True),
        ("Entry", ("Entrance",), True),
        ("Kitchen / Living", ("Kitchen", "Reception"), False),
        ("Study", ("Unknown",), False),
    ],
)
def test_rooms_without_a_carpet_are_told_by_types_or_name(name, types, bare):
    assert has_bare_floor(types, name) is bare
