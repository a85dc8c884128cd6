"""``croissant.json`` of a dataset: MLCommons' Croissant 1.0, with its vocabulary for responsible AI.

Version 1.0 suffices, and every reader of Croissant supports it.
"""

import json
from collections.abc import Mapping
from typing import Any

import pyarrow as pa

from vbbench.files.cards.readme import config_name, tags
from vbbench.files.cards.subject import Subject, citations, licence_address, said_licence
from vbbench.files.dataset_info import INFO_FILE

CONFORMS_TO = ["http://mlcommons.org/croissant/1.0", "http://mlcommons.org/croissant/RAI/1.0"]
PARQUET = "application/x-parquet"
_TERMS = (
    "citeAs column equivalentProperty extract field fileObject fileProperty fileSet format includes isLiveDataset "
    "jsonPath key md5 parentField path recordSet references regex repeated replace samplingRate separator source "
    "subField transform"
)
CONTEXT: dict[str, Any] = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "sc": "https://schema.org/",
    "cr": "http://mlcommons.org/croissant/",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "dct": "http://purl.org/dc/terms/",
    "conformsTo": "dct:conformsTo",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "examples": {"@id": "cr:examples", "@type": "@json"},
    **{term: f"cr:{term}" for term in _TERMS.split()},
}
_TYPES = {pa.int32(): "cr:Int32", pa.float32(): "cr:Float32", pa.float64(): "cr:Float64", pa.string(): "sc:Text"}


def croissant(subject: Subject, said: Mapping[str, Any]) -> str:
    """The text of ``croissant.json``."""
    info, origin, publisher = subject.info, subject.origin, subject.publisher
    licence = said_licence(origin, publisher)
    creator = publisher.creator and {"@type": "sc:Organization", "name": publisher.creator}
    published = {"creator": creator, "url": publisher.url, "datePublished": publisher.published}
    values = {
        "@context": CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": CONFORMS_TO,
        "name": f"{info.split}-{info.tier}-{subject.id}",
        "alternateName": info.title,
        "identifier": subject.id,
        "description": f"{info.title}. {said['kind'][0].upper()}{said['kind'][1:]}. {said['task']} {said['known']}",
        "version": "1.0.0",
        "license": licence_address(licence) or licence,
        "citeAs": " ".join(citations(origin, publisher)),
        "keywords": tags(subject),
        "isLiveDataset": False,
        **{name: value for name, value in published.items() if value},
        **_responsible(said),
        "distribution": [
            _file_object(INFO_FILE, "application/json", subject.info_file),
            *(_file_object(f"{name}.parquet", PARQUET, info.tables[name]) for name in subject.tables),
        ],
        "recordSet": [_record_set(subject, name) for name in subject.tables],
    }
    return json.dumps(values, indent=2, ensure_ascii=False) + "\n"


def _responsible(said: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of the vocabulary for responsible AI."""
    fields = {
        "dataCollection": said["collection"],
        "dataCollectionType": said["collection_types"],
        "dataCollectionRawData": said["raw"],
        "dataCollectionMissingData": said["missing"],
        "dataPreprocessingProtocol": said["preprocessing"],
        "dataLimitations": [*said["limitations"], *(f"Not for: {misuse}" for misuse in said["misuses"])],
        "dataBiases": said["biases"],
        "personalSensitiveInformation": [said["privacy"]],
        "dataUseCases": said["uses"],
        "dataSocialImpact": f"{said['sharing']} {said['misuses'][0]}",
        "dataReleaseMaintenancePlan": said["maintenance"],
    }
    return {f"rai:{name}": value for name, value in fields.items()}


def _file_object(name: str, kind: str, facts: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "@type": "cr:FileObject",
        "@id": name,
        "name": name,
        "contentUrl": name,
        "contentSize": f"{facts['bytes']} B",
        "encodingFormat": kind,
        "sha256": facts["sha256"],
    }


def _record_set(subject: Subject, table: str) -> dict[str, Any]:
    name, meaning = config_name(table), subject.meaning(table)
    return {
        "@type": "cr:RecordSet",
        "@id": name,
        "name": name,
        "description": meaning.about,
        "key": [{"@id": f"{name}/{column}"} for column in meaning.key],
        "field": [_field(table, *column) for column in subject.columns(table)],
    }


def _field(table: str, column: str, kind: pa.DataType, meaning: str) -> dict[str, Any]:
    refers = column == "sequence" and table != "sequences"
    return {
        "@type": "cr:Field",
        "@id": f"{config_name(table)}/{column}",
        "name": column,
        "description": meaning,
        "dataType": _TYPES[kind],
        "source": {"fileObject": {"@id": f"{table}.parquet"}, "extract": {"column": column}},
        **({"references": {"field": {"@id": "sequences/sequence"}}} if refers else {}),
    }
