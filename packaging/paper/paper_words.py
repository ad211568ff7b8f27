"""The words of the manual's page about the source paper's figures, English and French.

Of a figure the English words are the program's own; the French ones are here.
"""

from typing import NamedTuple


class Words(NamedTuple):
    """What one language's page says of a figure."""

    title: str
    situation: str
    shows: str
    found: str


class Frame(NamedTuple):
    """What one language's page says around the figures."""

    title: str
    beginning: str
    figure: str
    given: str
    shows: str
    found: str
    head: str


FRAMES = {
    "en": Frame(
        "The source paper's figures",
        "Georibbon began from a paper: N. Sprynski, N. Szafran, B. Lacolle and L. Biard, Surface "
        "reconstruction via geodesic interpolation, Computer-Aided Design 40 (2008), pages 480 to "
        "492. Here are its figures done again, by the paper's choice and by Georibbon's default. "
        "The paper gives no data with its figures: the situations are of the same kind, with "
        "numbers of our own, and what the paper shows is told in other words than its own.\n\n"
        "`georibbon figures -o DIR` does all of this anew in a minute, with every number in a "
        "file for programs.",
        "Figure {}. {}",
        "Given: {}",
        "The paper shows: {}",
        "Found: {}",
        "| whose | choice | result | numbers |",
    ),
    "fr": Frame(
        "Les figures de l'article d'origine",
        "Georibbon est né d'un article : N. Sprynski, N. Szafran, B. Lacolle et L. Biard, Surface "
        "reconstruction via geodesic interpolation, Computer-Aided Design 40 (2008), pages 480 à "
        "492. Voici ses figures refaites, selon le choix de l'article et selon celui que Georibbon "
        "fait de lui-même. L'article ne donne pas les données de ses figures : les situations sont "
        "de même nature, avec nos propres nombres, et ce que montre l'article est dit avec "
        "d'autres mots que les siens.\n\n"
        "`georibbon figures -o DOSSIER` refait tout cela en une minute, avec tous les nombres dans "
        "un fichier destiné aux programmes. Les mots dans les images sont en anglais.",
        "Figure {}. {}",
        "Données : {}",
        "L'article montre : {}",
        "Résultat : {}",
        "| choix de | choix | résultat | nombres |",
    ),
}

WHOSE = {
    "en": {"paper": "the paper", "georibbon": "Georibbon", "other": "besides"},
    "fr": {"paper": "l'article", "georibbon": "Georibbon", "other": "en plus"},
}

FIGURES_FR = {
    2: Words(
        "Longueurs des tangentes",
        "Deux demi-ellipses, de 0,50 sur 0,18 m et de 0,30 sur 0,09 m, dans des plans parallèles à "
        "0,18 m l'un de l'autre ; les lignes transversales partent le long de la corde, ramenée "
        "dans le plan tangent.",
        "Comment un morceau de surface entre deux courbes change avec la longueur de ses vecteurs "
        "de départ et d'arrivée : longs, ils le bombent près de leur courbe ; courts, ils "
        "l'aplatissent.",
        "Une longueur est la vitesse à laquelle une ligne part : grande, elle tire la surface de "
        "son côté ; petite, elle rend les lignes droites ; aucune de ces surfaces ne se replie. "
        "Les longueurs d'un arc sont ici proches de 1 : personne n'a à les choisir.",
    ),
    3: Words(
        "Deux courbes gauches",
        "Deux arcs de 0,30 m de rayon et de 1,8 rad, à 0,22 m l'un de l'autre, inclinés de côtés "
        "différents et qui sortent de leurs plans ; les lignes transversales partent le long des "
        "binormales.",
        "Un morceau de surface entre deux courbes gauches, avec des vecteurs de départ et "
        "d'arrivée le long de leurs binormales, si bien que les deux courbes en sont des "
        "géodésiques.",
        "Toutes sont entières ; aucune n'est près de se replier.",
    ),
    4: Words(
        "Binormales à une inflexion",
        "Deux courbes planes en S, longues de 0,52 m, hautes de 50 et de 35 mm de part et d'autre, "
        "dans des plans parallèles à 0,24 m l'un de l'autre ; seuls leurs points sont donnés.",
        "Une surface qui se rompt aux inflexions, là où se retournent les binormales dont elle "
        "part.",
        "Les binormales telles que les courbes les donnent déchirent la surface. Les repères que "
        "Georibbon tire d'une courbe seule ignorent le signe de la binormale : rien ne peut s'y "
        "retourner.",
    ),
    5: Words(
        "Binormales empêchées de se retourner",
        "Les courbes de la figure 4 ; une binormale qui pointe à l'opposé de la précédente est "
        "retournée.",
        "Les deux mêmes courbes, avec des vecteurs de départ qui continuent à travers les "
        "inflexions : une surface entière.",
        "Sur des courbes exactes la règle simple suffit, et les deux surfaces sont entières. Sur "
        "des courbes mesurées elle ne suffit pas : voir les figures 12 et 13.",
    ),
    6: Words(
        "Une binormale qui fait un tour",
        "Une vis élancée d'un seul tour, longue de 0,60 m, de 30 mm de rayon, à côté d'un arc "
        "distant de 0,20 m ; sa binormale fait un tour autour d'elle.",
        "Deux surfaces dont aucune n'est bonne : des vecteurs de départ tenus vers l'autre courbe "
        "la rompent, des vecteurs continus la font passer à travers elle-même.",
        "Aucun choix ne donne ici de surface entière, car les courbes demandent une surface qui "
        "s'enroule. La corde ramenée dans le plan tangent la déchire aussi ; le choix de Georibbon "
        "la garde d'un seul tenant, et ses contrôles disent qu'elle passe à travers elle-même.",
    ),
    7: Words(
        "Les quatre critères",
        "La deuxième et la troisième de cinq géodésiques d'une arche inégale, surface bicubique "
        "rationnelle de deux radians à 8 sur 7 points de contrôle ; lignes transversales le long "
        "des conormales. La vraie surface est connue.",
        "Quatre fois le même morceau, ses vecteurs de départ et d'arrivée choisis par chacun des "
        "quatre critères ; le quatrième est jugé le meilleur, et le troisième oscille.",
        "Le troisième n'a pas de minimum à l'intérieur : il va à sa borne inférieure, un quart de "
        "la corde, et se trompe le plus. Le quatrième, tel qu'imprimé, va lui aussi à ses bornes ; "
        "il est offert tenu près des angles sans aucune torsion, et vaut alors le premier. Les "
        "longueurs d'un arc, choix de Georibbon, ne demandent aucune recherche et les valent tous "
        "deux.",
    ),
    8: Words(
        "Une géodésique d'un cône",
        "Un cône de demi-angle a = 30° et la courbe qui passe au plus près à 0,25 m de son axe, "
        "sur 2 rad autour de l'axe, selon la formule imprimée, sa constante A lue de trois façons.",
        "Les géodésiques du cône sous forme close, avec une constante A imprimée comme la tangente "
        "de a à la puissance -1 ; les courbes des figures 9 et 10 en sont.",
        "C'est la puissance qui est voulue, non la fonction réciproque : avec A = 1 / tan a la "
        "courbe n'a pas de courbure géodésique sauf celle des arrondis ; avec les autres lectures "
        "elle n'est pas une géodésique du cône où elle se trouve : elle se courbe de côté, comme "
        "le disent les flèches. À 45° les deux dernières sont égales, 45° ne prouve donc rien.",
    ),
    9: Words(
        "Un cône, courbes alignées",
        "Deux géodésiques d'un cône de demi-angle 30°, à 0,30 et 0,39 m de son axe, sur les mêmes "
        "2 rad autour de lui : les points à parts égales des longueurs sont sur une même "
        "génératrice.",
        "Le cône reconstruit de deux de ses géodésiques, avec des courbes qui commencent et "
        "finissent sur les mêmes génératrices.",
        "Le long de la corde, à parts égales, chaque ligne transversale est une génératrice du "
        "cône et la surface est exacte aux arrondis près ; le long des binormales, non. Georibbon "
        "fait se correspondre les pieds des points, qui ne sont pas sur des génératrices, et se "
        "trompe de quelques micromètres.",
    ),
    10: Words(
        "Un cône, courbes décalées",
        "Les géodésiques de la figure 9, décalées de 0,2 rad autour de l'axe l'une par rapport à "
        "l'autre, à parts égales de leurs longueurs.",
        "Quand les courbes ne commencent pas sur les mêmes génératrices, les binormales comme "
        "vecteurs de départ déforment le cône ; des vecteurs le long de la corde projetée le "
        "réparent.",
        "Il en est ainsi, de deux ordres de grandeur. Faire se correspondre les pieds des points, "
        "comme Georibbon, répare l'une et l'autre sorte de vecteurs.",
    ),
    11: Words(
        "Une sphère, courbes décalées",
        "Deux grands cercles d'une sphère de 0,60 m de rayon, à 0,155 m l'un de l'autre en leurs "
        "milieux, longs de 0,72 m, décalés de 88 mm le long d'eux-mêmes.",
        "La même chose sur une sphère : le long de la corde projetée le morceau la suit, le long "
        "des binormales il ne la suit pas.",
        "Avec les longueurs d'un arc et la correspondance des pieds, les lignes transversales sont "
        "des arcs de cercle sur la sphère, à une fraction de micromètre près.",
    ),
    12: Words(
        "Binormales de courbes calculées",
        "Les cinq géodésiques de l'arche inégale, un point tous les 4 mm, chaque coordonnée avec "
        "une erreur de 0,001 mm ; aucune normale n'est donnée. Les binormales de l'article sont "
        "celles des points tels quels, les normales de Georibbon celles de points lissés comme "
        "leur bruit le demande ; et la surface qui en part.",
        "Les binormales de géodésiques calculées sur une surface libre tremblent, et la surface "
        "qui en part aussi.",
        "Une binormale demande des dérivées secondes, qu'un millième de millimètre suffit à gâter "
        "là où la courbe se courbe peu. Georibbon mesure le bruit, lisse les points d'autant, et "
        "trouve les normales par l'angle doublé, qui pèse chaque endroit selon sa courbure.",
    ),
    13: Words(
        "Binormales lissées",
        "Les cinq géodésiques de l'arche inégale, un point tous les 4 mm, chaque coordonnée avec "
        "une erreur de 0,001 mm ; aucune normale n'est donnée. Binormales lissées sur 100 mm, pour "
        "l'article celles des points tels quels, sinon celles de points lissés comme leur bruit le "
        "demande. En outre, la déchirure aux inflexions des courbes en S de la figure 4 avec les "
        "mêmes erreurs, la pire de cinq tirages.",
        "Les mêmes binormales après un ajustement par B-splines aux moindres carrés, et une "
        "surface lisse qui en part.",
        "Lisser répare des binormales qui tremblent, mais non celle qui s'est retournée, car "
        "l'ajustement la suit. L'angle doublé n'a pas de signe à manquer.",
    ),
    15: Words(
        "Une courbe d'après ses tangentes",
        "Une ligne de vis de 60 mm de rayon, longue de 0,45 m, avec 16 capteurs tous les 30 mm, "
        "qui disent chacun la tangente : exactement, puis avec des erreurs de 0,25° autour des "
        "deux axes, 40 tirages.",
        "Une courbe retrouvée d'après les seules tangentes aux capteurs, par une courbe sphérique "
        "lisse qui passe par elles et son intégrale.",
        "Toutes les courbes sphériques lisses se valent : avec des tangentes exactes elles se "
        "trompent d'un centième de millimètre, et avec les erreurs des capteurs elles dérivent "
        "toutes de même, comme ces erreurs le laissent attendre. Les moyennes sphériques tiennent "
        "ici lieu de la courbe sphérique de l'article.",
    ),
    16: Words(
        "Une surface par cinq géodésiques",
        "L'arche inégale de la figure 7 avec ses cinq géodésiques, longues de 0,72 m, à 69 mm "
        "l'une de l'autre en moyenne : exactes, puis telles que les disent des capteurs tous les "
        "30 mm, avec des erreurs de 0,25° chacun, leurs milieux placés exactement.",
        "Une surface libre, des géodésiques que l'on y suit par le calcul, et la surface "
        "reconstruite d'après elles.",
        "Des courbes exactes donnent la surface à moins de deux dixièmes de millimètre près, quel "
        "que soit le choix, autant que les intervalles le permettent ; ce qui limite une surface "
        "mesurée, ce sont les angles des capteurs.",
    ),
    17: Words(
        "Un capot de voiture par un ruban",
        "Un ruban virtuel de 32 capteurs, long de 0,96 m, avec les erreurs d'un vrai, étalonné "
        "d'après des poses et posé sur un capot de voiture virtuel en 7 passes, dont les bouts "
        "sont repérés, et deux liaisons en travers.",
        "Un objet réel, une pièce de voiture, sur lequel un ruban de capteurs est posé plusieurs "
        "fois, et la surface d'après ses mesures.",
        "L'objet est ici virtuel, pour que sa vraie forme soit connue. Ajuster toutes les mesures "
        "à la fois à ce qu'un ruban peut faire, et aux repères, en approche de plus près qu'une "
        "courbe tirée des tangentes de chaque passe.",
    ),
}

# Names of choices, verdicts and numbers.
PHRASES_FR = {
    "Georibbon's default": "choix de Georibbon",
    "Georibbon's default: unrolled": "choix de Georibbon : déroulement",
    "binormals, λ = 1": "binormales, λ = 1",
    "binormals, λ = 0.4": "binormales, λ = 0.4",
    "binormals as they come": "binormales telles quelles",
    "binormals kept": "binormales continues",
    "binormals kept from turning over": "binormales continues",
    "binormals towards the arc": "binormales vers l'arc",
    "along the chord": "le long de la corde",
    "safe chord, λ = 1": "corde sûre, λ = 1",
    "projected chord, λ = 1": "corde projetée, λ = 1",
    "criterion 1: the speed varies least": "critère 1 : la vitesse varie le moins",
    "criterion 2: the curvature varies least": "critère 2 : la courbure varie le moins",
    "criterion 3: least torsion, by lengths": "critère 3 : torsion minimale, par les longueurs",
    "criterion 4: least torsion, by angles": "critère 4 : torsion minimale, par les angles",
    "least-squares B-spline, 100 mm": "B-spline aux moindres carrés, 100 mm",
    "doubled angle, 100 mm": "angle doublé, 100 mm",
    "spherical averages": "moyennes sphériques",
    "components, made unit": "composantes, rendues unitaires",
    "default, sensors with 0.25°": "le même, capteurs à 0.25°",
    "from tangents, along the chord": "d'après les tangentes, le long de la corde",
    "whole": "entière",
    "torn": "déchirée",
    "folded": "repliée",
    "runs through itself": "se traverse",
    "at its bounds": "aux bornes",
    "torn at inflections": "déchirée aux inflexions",
    "a geodesic": "une géodésique",
    "no geodesic": "pas une géodésique",
    "drifts as expected": "dérive comme attendu",
    "drifts more than expected": "dérive plus qu'attendu",
}

SHORT_FR = {
    "rms_mm": "eqm {} mm",
    "max_mm": "max {} mm",
    "normal_rms_deg": "normales eqm {}°",
    "normal_max_deg": "normales max {}°",
    "normal_jump_deg": "saut des normales {}°",
    "tear_ratio": "rapport de déchirure {}",
    "s_curve_tear_ratio": "courbes en S : déchirure {}",
    "self_crossing_pairs": "traversées {}",
    "fold_least": "repli {}",
    "sine_least": "sinus minimal {}",
    "skew_greatest_deg": "biais {}°",
    "lambda_least": "λ de {}",
    "lambda_greatest": "λ à {}",
    "start_speed": "départ {}",
    "middle_speed": "milieu {}",
    "end_speed": "arrivée {}",
    "line_length": "longueur {}",
    "geodesic_curvature_max_per_m": "courbure géodésique {} 1/m",
    "curve_error_max_mm": "tangentes exactes : {} mm",
    "end_error_mm": "bout {} mm",
    "end_error_expected_mm": "attendu {} mm",
    "curves_rms_mm": "courbes eqm {} mm",
}

LEGEND = {
    "en": "Tear ratio: the longest step of the surface along the curves over the usual one; above "
    "3 it is torn. Fold: 1 where it lies as its normals say, not above 0 where it folds over. "
    "Crossings: pairs of triangles of a coarse mesh that run through each other. Skew: how far "
    "points that are joined lie from straight across. λ: the length of a tangent over its chord. "
    "Starts, middle, ends, length: of the lines across, their speed and length over the chord. "
    "rms, max: distance to the true surface. In the pictures, red strokes are the conormals, and "
    "the surface's other side is brown.",
    "fr": "Rapport de déchirure : le plus long pas de la surface le long des courbes, rapporté au "
    "pas usuel ; au-dessus de 3 elle est déchirée. Repli : 1 où elle est posée comme le disent ses "
    "normales, pas au-dessus de 0 où elle se replie. Traversées : paires de triangles d'un "
    "maillage grossier qui se traversent. Biais : de combien les points joints sont loin de se "
    "faire face. λ : la longueur d'une tangente, rapportée à sa corde. Départ, milieu, arrivée, "
    "longueur : vitesse et longueur des lignes transversales, rapportées à la corde. eqm, max : "
    "écart quadratique moyen et plus grand écart à la vraie surface. Dans les images, les traits "
    "rouges sont les conormales, et l'envers de la surface est brun.",
}
