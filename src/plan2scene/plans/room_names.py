"""Names of rooms in several languages, and the room type that each name means."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from functools import lru_cache

from plan2scene.house import ROOM_TYPES

#: Stems of the names of garages; see `_STEMS`.
_GARAGE = "garage gar garaje box_auto garagem garasje autotalli garaz garaj гараж"
#: The same of laundries and utility rooms.
_LAUNDRY = (
    "utility util laundry laund lndry ldry l_dry ldy buand lavanderia lavadero lavandaria "
    "bijkeuken hwr hauswirtschaft tvatt tvattstuga vaskerom bryggers kodinhoitohuone pralnia "
    "wasruimte washok waschkuche area_de_servico pradelna praonica 다용도실 세탁실 洗衣"
)
#: Stems of words (lower case, no accents; `_` for a space) by room type. The first type with a stem
#: in a name decides: "bathroom" is found before "room" could be. Indoor rooms of a use that has no
#: type (garage, office) are Unknown.
_STEMS = {
    "Bathroom": (
        "bath bathrm bathroom masterbath badez bad salle_de_bain salle_deau bano aseo bagno bth "
        "badk badkamer shower shwr shr dusche douche ducha doccia wc toil toilet toilette lav "
        "lavatory restroom washroom ens ensuite en_suite powder powd pwdr pwd pdr servizi sauna "
        "lavabo badrum dusch sdb sde duschbad banheiro "
        "casa_de_banho lavatorio bad_en_suite baderom badevaerelse toalett kylpyhuone "
        "kph khh kh ph sd_b sd_e elternbad gastebad "
        "pesuhuone suihku laz lazienka toaleta banyo tuvalet koupelna kupelna furdo "
        "furdoszoba kupaonica kupatilo kopalnica vannituba vonia vannasistaba phong_tam "
        "nha_ve_sinh kamar_mandi bilik_air bilik_mandi ванн санузел санвузол с_у туалет душев "
        "μπανιο λουτρο τουαλετα אמבטיה שירותים מקלחת רחצה حمام 浴室 洗面 トイレ 風呂 "
        "バス 厠 卫生间 衛生間 洗手间 厕所 욕실 화장실"
    ),
    "Kitchen": (
        "kitchen kit kitch ktchn kuche kueche kuch kuchen kochen cuisine cuis cocina coc cucina "
        "cuc keuken kitchenette scullery "
        "pantry_kitchen butlers_pantry kok kokken kjokken kjk cozinha coz keittio kk kt kuchnia "
        "aneks_kuchenny mutfak kuchyn kuchyne konyha bucatarie kuhinja kook virtuve bep dapur "
        "cottura кухн κουζινα מטבח مطبخ キッチン 台所 厨房 廚房 주방 부엌"
    ),
    "Bedroom": (
        "bedroom bedrm bdrm br mbr schlaf sz chambre chbre dormitorio dorm habitacion hab camera "
        "cam cameretta slaapk slpk kinderz kind kids guest gastez nursery alcoba recamara cuarto "
        "eltern gaste alkovi alk "
        "bed sovrum sov letto ch suite quarto sovevaerelse vaerelse soverom makuuhuone mh "
        "sypialnia pokoj pok yatak_odasi cocuk_odasi ebeveyn_odasi loznice haloszoba halo "
        "gyerekszoba dormitor spavaca spalnica soba magamistuba miegamasis gulamistaba phong_ngu "
        "kamar_tidur bilik_tidur gastrum barnrum kabinett спальн детск дитяч υπνοδωματι "
        "שינה ילדים הורים ממ_ד نوم النوم 寝室 洋室 和室 子供部屋 卧 臥室 睡房 儿童房 客房 침실 안방"
    ),
    "Balcony": "balcon balcony balc balkon balcone loggia balkong altan varanda parveke parv "
    "balkonu "
    "lodzie lodzia loda erkely rodu ban_cong marquise лоджия балкон μπαλκονι מרפסת شرفة بلكونة "
    "バルコニー ベランダ 阳台 陽台 발코니 베란다",
    "Terrace": (
        "terrace terrasse terraza terrazza terras terr patio deck porch portico veranda pavilion "
        "alfresco terraco terassi taras teras terrazzo uteplats lanai терраса βεραντα "
        "テラス 露台 테라스"
    ),
    "Outdoor": (
        "outdoor outside garden garten jardin giardino tuin yard courtyard carport exterior "
        "draussen hof parking jardim have hage piha autokatos ogrod bahce zahrada kert "
        "сад גינה חצר 庭"
    ),
    "Staircase": (
        "stair stairs staircase treppe treppenhaus escalier escalera scala scale trap "
        "escada trappe trappa portaat schody klatka_schodowa merdiven schodiste lepcso stubiste "
        "лестница σκαλα מדרגות درج 階段 楼梯 樓梯 계단"
    ),
    "Entrance": (
        "entry ent entrance entree eingang foyer vestibule recibidor entrada ingresso ingr lobby "
        "mudroom mud_room mud windfang vorraum draughtlobby entre eteinen et tk wiatrolap antre "
        "vorzimmer vindfang boot_room predsin predsien zadveri eloszoba predsoblje esik "
        "прихож тамбур передпок εισοδος כניסה مدخل 玄関 玄关 玄關 门厅 현관"
    ),
    "Corridor": (
        "corridor hall hal hallway flur diele gang couloir pasillo corridoio disimp passage dgt "
        "deg landing degagement overloop distribuidor corredor korridor gangen aula kaytava "
        "przedp korytarz hol koridor palier chodba kozlekedo folyoso hodnik gaitenis hanh_lang "
        "коридор холл διαδρομος χολ מסדרון פרוזדור ممر 廊下 ホール 走廊 过道 복도"
    ),
    "Closet": (
        "closet wardrobe storage store stor sto abstell abst kammer dress dressing placard pl "
        "cellier armario vestidor trastero despensa ripostiglio rip sgabuzzino berging berg kast "
        "pantry ptry wip cupboard cupbd cpbd cpd walkin w_i speisekammer ankleide larder klk "
        "kladkammare forrad garderob bir wir wic sic robe linen lin cub rangement rgt lager "
        "arrumos roupeiro bod skab garderobe pukuhuone pukuh vaatehuone "
        "vh varasto garderoba gard spizarnia schowek kiler cabina_armadio inloopkast meterkast "
        "walk_in cloaks depot satna komora spiz gardrob kamra debara ostava spremiste shramba "
        "гардероб кладов комора αποθηκη ארון מחסן مخزن クローゼット 収納 押入 物入 納戸 储藏 "
        "储物 衣帽 드레스룸 창고 팬트리"
    ),
    "Unknown": (
        f"{_GARAGE} {_LAUNDRY} lift elevator "
        "aufzug ascenseur ascensor technical technik mech loft attic basement "
        "heizung heizungsraum keller cellar cave plant workshop werkstatt "
        "vaerksted verksted "
        "gym study stdy office buro arbeitsz bureau despacho ufficio werkkamer escritorio kontor "
        "tyohuone gabinet calisma_odasi kantoor zolder cantina pracovna dolgozo birou mezzanine "
        "mechanical кабинет кабінет γραφειο 书房 書房 서재"
    ),
    "Reception": (
        "living liv lvg reception wohnz wohnen wohn wz sejour sej salon sala soggiorno sogg woonk "
        "lounge lnge dining din diner sitting esszimmer essen salle_a_manger comedor pranzo "
        "eetkamer family fam den meals media cinema snug rumpus sunroom conservatory playroom "
        "library great_room great_rm drawing parlour parlor studio stube zimmer vardagsrum "
        "matplats allrum activity theatre estar stue stua spisestue spisestuen faellesrum alrum "
        "olohuone oh ruokailu ruok tupakeittio jadalnia salonu oturma_odasi yasam "
        "salotto obyvak obyvaci obyvacka jidelna nappali etkezo sufragerie boravak blagovaonica "
        "elutuba svetaine viesistaba phong_khach phong_an ruang_tamu ruang_keluarga ruang_makan "
        "kjellerstue breakfast rec_room rec_rm games_room bonus_room гостин зал столов вітальн "
        "їдальн σαλονι καθιστικο τραπεζαρια סלון מגורים אוכל معيشة المعيشة جلوس الجلوس صالون صالة "
        "リビング ダイニング 居間 客厅 客廳 餐厅 餐廳 起居室 거실 식당 ldk"
    ),
}
#: Names that match only as a whole: "zimmer" alone is a bedroom (German); abbreviations.
_WHOLE = {"zimmer": "Bedroom", "pokoj dzienny": "Reception", "w i cl": "Closet", "k": "Kitchen"}
_WHOLE |= dict.fromkeys(("c", "cl", "st"), "Closet")
_WHOLE |= dict.fromkeys(("obyvaci pokoj", "dnevna soba", "dnevni prostor"), "Reception")
_WHOLE |= {"baie": "Bathroom", "szoba": "Bedroom"}  # a bay in French; part of longer words
_TYPES = {name.lower(): name for name in ROOM_TYPES} | _WHOLE


#: Latin letters that Unicode does not decompose into a letter and an accent.
WRITTEN = str.maketrans(
    {"æ": "ae", "œ": "oe", "ø": "o", "ł": "l", "đ": "d", "ð": "d", "þ": "th", "ß": "ss", "ı": "i"}
    | {"Æ": "Ae", "Œ": "Oe", "Ø": "O", "Ł": "L", "Đ": "D", "Ð": "D", "Þ": "Th"}
)


@lru_cache(maxsize=1024)
def room_types(name: str) -> tuple[str, ...]:
    """Return the room types that a name means, in the order of its words; empty for none.

    A name may join several rooms ("Living / Kitchen"): each part is read alone. A room of a use
    that has no type ("Garage") is Unknown.
    """
    types: list[str] = []
    for part in re.split(r"(?<!\b[wWсС])[/+&,;|]| und | and | et | y | e | en ", f"{name} "):
        kind = _type_of(part)
        if kind is not None and kind not in types:
            types.append(kind)
    return tuple(kind for kind in types if kind != "Unknown") or tuple(types)


def is_garage(name: str) -> bool:
    """Return whether a name means a garage, and no room of another type."""
    return room_types(name) == ("Unknown",) and _has_stem(_words_of(name), _GARAGE)


def has_bare_floor(types: Sequence[str], name: str) -> bool:
    """Return whether a room is only a kitchen, laundry or entrance: few of them have a carpet."""
    laundry = room_types(name) == ("Unknown",) and _has_stem(_words_of(name), _LAUNDRY)
    return laundry or tuple(types) in (("Kitchen",), ("Entrance",))


def _type_of(text: str) -> str | None:
    """Return the room type of one name."""
    words = _words_of(text)
    plain = " ".join(words)
    if plain in _TYPES:
        return None if plain == "unknown" else _TYPES[plain]
    return next((kind for kind, stems in _STEMS.items() if _has_stem(words, stems)), None)


def _words_of(text: str) -> list[str]:
    """Return the words of a name, lower case and without accents."""
    plain = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", text).translate(WRITTEN)
    plain = unicodedata.normalize("NFKC", _without_accents(plain)).lower()
    plain = re.sub(r"(?<=\b\w)[.](?=\w\b)|['’`´]", "", plain)  # "W.I.R.", "L'DRY"
    return re.sub(r"[\W\d_]+", " ", plain).split()


def _has_stem(words: Sequence[str], stems: str) -> bool:
    """Return whether the words of a name contain one of the `stems`."""
    joined = f"_{'_'.join(words)}"
    return any(
        ("_" in stem and f"_{stem}" in joined) or any(_is(word, stem) for word in words)
        for stem in stems.split()
    )


def _without_accents(text: str) -> str:
    """Return a text without accents of Latin and Greek letters; other scripts keep their marks."""
    parts = []
    for letter in text:
        plain = unicodedata.normalize("NFKD", letter)
        bare = plain[:1].isascii() or "α" <= plain[:1].lower() <= "ω"
        parts.append(plain[0] if bare and len(plain) > 1 else letter)
    return "".join(parts)


def _is(word: str, stem: str) -> bool:
    """Return whether a word is a stem, its plural, or (long stems) begins or ends with it.

    In scripts without spaces it may be anywhere in a word; Hebrew and Russian words begin with it.
    """
    if not stem.isascii():
        return stem in word if stem > "\u3000" else word.startswith(stem)
    if word in (stem, f"{stem}s", f"{stem}es", f"{stem}n"):
        return True
    return len(stem) >= 5 and (word.startswith(stem) or word.endswith(stem))
