"""`surefoot bench speeds`: JSON alone on stdout."""


def test_a_ladder_of_speeds(answer):
    (row,) = answer("bench", "speeds", "--quick")
    assert row["robot"] == "go2"
    assert row["commanded"] == row["wanted"] == [0.5, 0.0, 0.0]
    assert (row["walked"], row["good"], row["lawful"]) == (1, 1, 1)
    assert 0.3 < row["speed_use"] < 0.8
    assert row["usual_rate"] < 4.0
