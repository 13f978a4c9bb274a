"""Write findings as SARIF 2.1.0."""

import json
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path

from ipoa_mission.finding import Finding
from ipoa_mission.rules import RULES


def sarif(found: Mapping[Path, Sequence[Finding]]) -> str:
    codes = sorted({finding.code for findings in found.values() for finding in findings})
    rules = [
        {"id": code, "shortDescription": {"text": RULES[code].means}, "help": {"text": RULES[code].do}}
        for code in codes
    ]
    results = [
        {
            "ruleId": finding.code,
            "ruleIndex": codes.index(finding.code),
            "level": str(finding.severity),
            "message": {"text": finding.message + (f" ({finding.hint})" if finding.hint else "")},
            "locations": [
                {
                    "physicalLocation": {"artifactLocation": {"uri": file.as_posix()}},
                    "logicalLocations": [
                        {"name": "mission" if finding.seq is None else f"item {finding.seq}", "kind": "element"}
                    ],
                }
            ],
        }
        for file, findings in found.items()
        for finding in findings
    ]
    driver = {"name": "ipoa-mission", "version": version("ipoa-mission"), "rules": rules}
    schema = "https://json.schemastore.org/sarif-2.1.0.json"
    log = {"$schema": schema, "version": "2.1.0", "runs": [{"tool": {"driver": driver}, "results": results}]}
    return json.dumps(log, indent=2) + "\n"
