"""Sentences of Okuma's user tasks."""

from __future__ import annotations

from tests.advice.follow import WRITE, Case

SUB = "O2|G1 X=PX F.1|RTS"
MAIN = "G0 X90. Z9.|"


def task(before: str, after: str, then: str = "", **options) -> Case:
    return Case(
        "okuma-lathe", MAIN + before, MAIN + after, then,
        how={**WRITE, **options.pop("how", {})}, **options,
    )  # fmt: skip


ALL = [
    task("CALL 2|M2|" + SUB, "CALL O2 PX=50|M2|" + SUB),
    task("IF V1 EQ 3 N2|N2 X80.", "V1=3|IF [V1 EQ 3] N2|N2 X80."),
    task("V1=1|X=V1*20.5", "V1=1|X=V1*20", how={"integers": "least increments"}),
    task("X=V1", "V1=50|X=V1"),
    task("X=VZOFZ[1]", "V1=50|X=V1"),
    task("MODIN O2|MODIN O2|M2|O2|G4 F1|RTS", "MODIN O2|X80.|MODOUT|M2|O2|G4 F1|RTS"),
    task("PX=50|X80.|$ Z=PX", "PX=50|X80. Z=PX"),
    task("N1 X80.|GOTO N1", "N1 X80.", first={"steps": 9}),
    task("CALL O2|M2|O2|CALL O2|RTS", "CALL O2|M2|O2|X80.|RTS"),
    task("CALL O2 PX=50|" + SUB, "CALL O2 PX=50|M2|" + SUB),
    task("GOTO N7|X80.", "GOTO N7|N7 X80."),
    task("CALL O7 PX=50|M2", "CALL O7 PX=50|M2", also={"library": {"O7": SUB.replace("2", "7")}}),
    task("GOTO N7|N7 X80.|N7 X70.", "GOTO N7|N7 X80.|N8 X70."),
    task("X=SQRT[0-1]", "X80."),
    task(
        "V1=40|NAT01 G81|G0 X=V1 Z2.|G1 Z-5. F.1|G80|V1=30|G87 NAT01",
        "V1=40|NAT01 G81|G0 X=V1 Z2.|G1 Z-5. F.1|G80|G87 NAT01|V1=30",
    ),
    task(
        "V1=40|G87 NAT01|M2|NAT01 G81|G0 X=V1 Z2.|G1 Z-5. F.1|G80",
        "V1=40|NAT01 G81|G0 X=V1 Z2.|G1 Z-5. F.1|G80|G87 NAT01|M2",
    ),
]
